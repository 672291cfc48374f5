# SPDX-License-Identifier: BSD-3-Clause
"""Paths through configurations, and jerk-limited motion along them."""
