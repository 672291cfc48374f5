# SPDX-License-Identifier: BSD-3-Clause
"""Move: RCM-constrained motion of a Gen3 with an OpenRST forceps (Robotic Surgical Tool)."""
