# SPDX-License-Identifier: BSD-3-Clause
"""The results: what came of each phrase, as the recordings show it."""
