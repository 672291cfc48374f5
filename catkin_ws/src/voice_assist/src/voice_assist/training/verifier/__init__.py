# SPDX-License-Identifier: BSD-3-Clause
"""Training of the verifier of phrases."""
