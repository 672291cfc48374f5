# SPDX-License-Identifier: BSD-3-Clause
"""The arm for clients of the Collaborative Robotics Toolkit."""
