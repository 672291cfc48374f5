# SPDX-License-Identifier: BSD-3-Clause
"""From frames of sound to commands."""
