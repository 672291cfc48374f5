# SPDX-License-Identifier: BSD-3-Clause
"""The ROS edge of rst_control: nothing outside this folder imports ROS."""
