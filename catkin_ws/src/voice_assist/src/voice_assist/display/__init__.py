# SPDX-License-Identifier: BSD-3-Clause
"""The operator's page: one snapshot of the theatre, served to browsers; knows nothing of ROS."""
