# SPDX-License-Identifier: BSD-3-Clause
"""Devices of the theatre: which call follows a spoken command or a stop; knows nothing of ROS."""
