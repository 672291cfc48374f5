# SPDX-License-Identifier: BSD-3-Clause
"""The controller's state, as it comes: whether the robot moves, and its mode."""

from __future__ import annotations

from collections.abc import Callable

import rospy

from rst_control.msg import ControllerState
from voice_assist.pipeline.robot_mode import RobotMode
from voice_assist.pipeline.robot_motion import RobotMotion

TOPIC = "rst_control/state"


def follow_controller(motion: RobotMotion, mode: RobotMode, clock: Callable[[], float]) -> None:
    """Report each state to the rules, by a steady clock [s]."""

    def take(message: ControllerState) -> None:
        now = clock()
        motion.report(message.state, message.assistance_enabled, now)
        mode.report(message.assistance_enabled, now)

    rospy.Subscriber(TOPIC, ControllerState, take, queue_size=1)
