# SPDX-License-Identifier: BSD-3-Clause
"""What a launch asks ROS before it starts."""
