# SPDX-License-Identifier: BSD-3-Clause
"""The controller's way to a real Kinova Gen3 with OpenRST: set-points to what their drivers take.

Towards the controller this is the simulated robot's interface, towards the hardware that of the
drivers; so the controller does not know which robot it moves. Nothing here imports ROS.
"""
