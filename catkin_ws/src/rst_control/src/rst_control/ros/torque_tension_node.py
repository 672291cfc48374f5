# SPDX-License-Identifier: BSD-3-Clause
"""The node that tells the tissue's pull from joint torques, for robots without a force sensor."""

from __future__ import annotations

import sys
import time

import numpy as np
import rospy
from geometry_msgs.msg import PointStamped, WrenchStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, String

from rst_control.errors import RstError
from rst_control.ros.network import warn_of_listeners
from rst_control.torque_tension import TensionEstimate, TorqueTension
from rst_control.torque_tension_config import TorqueTensionConfig
from rst_control.types import JOINTS, Measurement, Vector
from typed_config import ConfigError, load_config

BASE = "base_link"
OLD = 0.2  # [s] joint states that are older are none


class TorqueTensionNode:
    """Takes in the newest joint states at a fixed rate; callbacks only keep them.

    Args:
        config: Of the estimator.
        description: URDF text of the robot.
    """

    def __init__(self, config: TorqueTensionConfig, description: str) -> None:
        self._estimator = TorqueTension(config, description)
        self._joints: JointState | None = None
        self._arrived = 0.0
        self._trocar: Vector | None = None
        self._is_gripped = False
        self._said: str | None = None
        self._tension = rospy.Publisher("robot/tension", WrenchStamped, queue_size=1)
        self._distrust = rospy.Publisher("robot/tension_distrust", String, queue_size=1, latch=True)
        newest = {"tcp_nodelay": True, "queue_size": 1}
        self._subscribers = [
            rospy.Subscriber("joint_states", JointState, self._on_joints, **newest),
            rospy.Subscriber("robot/gripped", Bool, self._on_gripped),
            rospy.Subscriber("rst_control/trocar", PointStamped, self._on_trocar),
        ]

    def step(self) -> None:
        """Take in the newest joint states and tell what they say."""
        joints, trocar = self._joints, self._trocar
        if trocar is None:
            self._say("the trocar is not known yet")
        elif joints is None or time.monotonic() - self._arrived > OLD:
            self._say("joint states are missing")
        else:
            self._tell(joints, self._estimator.update(self._measurement(joints), trocar))

    def _measurement(self, joints: JointState) -> Measurement:
        """Joint states in the order of JOINTS.

        Raises:
            RstError: A joint is missing, or has no effort.
        """
        rows = {}
        for row in ("position", "velocity", "effort"):
            values = dict(zip(joints.name, getattr(joints, row), strict=False))
            missing = [name for name in JOINTS if name not in values]
            if missing:
                raise RstError(f"joint states without {row} of {', '.join(missing)}")
            rows[row] = np.array([values[name] for name in JOINTS])
        return Measurement(**rows, stamp=self._arrived, gripped=self._is_gripped)

    def _tell(self, joints: JointState, found: TensionEstimate) -> None:
        message = WrenchStamped()
        message.header.stamp, message.header.frame_id = joints.header.stamp, BASE
        force = message.wrench.force
        force.x, force.y, force.z = found.force
        self._tension.publish(message)
        self._say(found.distrust)

    def refuse(self, why: str) -> None:
        """Say that the newest joint states cannot be used."""
        self._say(why)

    def _say(self, distrust: str) -> None:
        if distrust != self._said:
            self._said = distrust
            self._distrust.publish(String(distrust))

    def _on_joints(self, message: JointState) -> None:
        self._joints, self._arrived = message, time.monotonic()

    def _on_gripped(self, message: Bool) -> None:
        self._is_gripped = message.data

    def _on_trocar(self, message: PointStamped) -> None:
        self._trocar = np.array([message.point.x, message.point.y, message.point.z])


def main() -> None:
    """Run the node."""
    rospy.init_node("torque_tension")
    try:
        config = load_config(
            TorqueTensionConfig, rospy.get_param("~", {}), "torque_tension parameters"
        )
        node = TorqueTensionNode(config, rospy.get_param("robot_description"))
    except (ConfigError, RstError, KeyError) as error:
        rospy.logfatal(f"torque_tension cannot start: {error}")
        sys.exit(2)
    warn_of_listeners()
    pace = 1.0 / config.rate
    while not rospy.is_shutdown():
        due = time.monotonic() + pace
        try:
            node.step()
        except (RstError, ValueError) as error:  # a message that cannot be used: say so, go on
            node.refuse(str(error))
        time.sleep(max(0.0, due - time.monotonic()))
