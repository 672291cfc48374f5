# SPDX-License-Identifier: BSD-3-Clause
"""Changes to the inside of rospy: bounds of what it takes in, and publishing without waiting."""
