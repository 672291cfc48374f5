# SPDX-License-Identifier: BSD-3-Clause
"""The controller's state, as it comes, for the rule whether the robot moves."""

from __future__ import annotations

from collections.abc import Callable

import rospy

from rst_control.msg import ControllerState
from voice_assist.pipeline.robot_motion import RobotMotion

TOPIC = "rst_control/state"


def follow_controller(motion: RobotMotion, clock: Callable[[], float]) -> None:
    """Report each state to the rule, by a steady clock [s]."""

    def take(message: ControllerState) -> None:
        motion.report(message.state, message.assistance_enabled, clock())

    rospy.Subscriber(TOPIC, ControllerState, take, queue_size=1)
