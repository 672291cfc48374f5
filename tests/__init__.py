# SPDX-License-Identifier: BSD-3-Clause
"""Tests; `python -m tests` runs them."""
