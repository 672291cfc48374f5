# SPDX-License-Identifier: BSD-3-Clause
"""An hour of listening without a break."""
