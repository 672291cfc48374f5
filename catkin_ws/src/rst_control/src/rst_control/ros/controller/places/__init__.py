# SPDX-License-Identifier: BSD-3-Clause
"""Trocar and grasp point on ROS: services, topics, trackers, and what outlives a restart."""
