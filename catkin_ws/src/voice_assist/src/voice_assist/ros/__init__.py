# SPDX-License-Identifier: BSD-3-Clause
"""The voice node; only here is ROS known."""
