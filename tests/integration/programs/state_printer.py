# SPDX-License-Identifier: BSD-3-Clause
"""Prints time [s] and name of each state that the controller publishes, until it is ended."""

import rospy

from rst_control.msg import ControllerState


def show(message: ControllerState) -> None:
    print(message.header.stamp.to_sec(), message.state, flush=True)


rospy.init_node("state_printer")
rospy.Subscriber("rst_control/state", ControllerState, show, queue_size=1)
rospy.spin()
