# SPDX-License-Identifier: BSD-3-Clause
"""The protocol of a robot, and the joint servo that simulated and real robot share."""
