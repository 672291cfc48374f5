# SPDX-License-Identifier: BSD-3-Clause
"""The edge to ROS: the only place of this package that imports it."""
