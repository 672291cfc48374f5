# SPDX-License-Identifier: BSD-3-Clause
"""What stops the robot: watchdogs and the plausibility of sensors."""
