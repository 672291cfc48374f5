# SPDX-License-Identifier: BSD-3-Clause
"""The machine and its ROS master: sockets, processes."""
