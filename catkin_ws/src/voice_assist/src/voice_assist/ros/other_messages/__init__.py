# SPDX-License-Identifier: BSD-3-Clause
"""Sound from, and results for, nodes that speak other packages' messages."""
