# SPDX-License-Identifier: BSD-3-Clause
"""Pedals: from pressed buttons to commands, talk gate and dead-man; knows nothing of ROS."""
