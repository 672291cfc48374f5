# SPDX-License-Identifier: BSD-3-Clause
"""Figures of the robot's motion: planning, control, braking, tension and triangulation."""
