# SPDX-License-Identifier: BSD-3-Clause
"""What a site does that the simulation does not: faults of sensors, arms and people, drawn."""
