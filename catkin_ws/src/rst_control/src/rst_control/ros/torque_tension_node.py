# SPDX-License-Identifier: BSD-3-Clause
"""The node that estimates the tissue's pull from joint torques, where no sensor measures it."""

from __future__ import annotations

import threading
import time
from collections import deque

import numpy as np
import rospy
from geometry_msgs.msg import PointStamped, WrenchStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, String

from rst_control.config import SceneConfig
from rst_control.config.torque_tension import TorqueTensionConfig
from rst_control.errors import RstError
from rst_control.ros.common.exposure_warning import warn_of_listeners
from rst_control.ros.common.priority import ask_for_priority
from rst_control.tension.clock_offset import SentTimes
from rst_control.tension.torque_estimator import TensionEstimate, TorqueTension
from rst_control.types import BASE, JOINTS, Measurement, Vector
from typed_config import ConfigError, load_config
from typed_config.ros.known_publishers import KnownPublishers
from typed_config.ros.launch_settings import launch_settings
from typed_config.ros.private_settings import robot_description
from typed_config.ros.starting import starting

OLD = 0.2  # [s] joint states that are older are none
SOONER = 0.1  # share of the period by which a reading may come before the next is due
KEPT = 40  # readings that wait while this process does not run


class TorqueTensionNode:
    """Takes in joint states as far apart as its rate says; callbacks only keep them.

    How far they are apart goes by their stamps, so a process that did not run for a moment makes
    up for it with the same readings.

    Args:
        config: Of the estimator.
        description: URDF text of the robot.
        scene: Of the controller beside it.

    Raises:
        RobotModelError: The URDF is not this robot's, or says another way of gravity.
        ConfigError: The scene leaves the way of the pull open.
    """

    def __init__(self, config: TorqueTensionConfig, description: str, scene: SceneConfig) -> None:
        self._estimator = TorqueTension(config, description, scene)
        self._readings: deque[tuple[JointState, float]] = deque(maxlen=KEPT)  # and when taken [s]
        self._news = threading.Event()
        self._min_period = (1.0 - SOONER) / config.rate
        self._times, self._taken, self._arrived = SentTimes(OLD), -np.inf, -np.inf
        self._trocar: Vector | None = None
        self._is_gripped = False
        self._said: str | None = None
        self._tension = rospy.Publisher("robot/tension", WrenchStamped, queue_size=1)
        invalid = "robot/tension_invalid_reason"
        self._invalid_reason = rospy.Publisher(invalid, String, queue_size=1, latch=True)
        self.known = KnownPublishers()
        listen, by = self.known.subscribe, config.believed
        self._subscribers = [
            listen("joint_states", JointState, self._on_joints, by.robot, tcp_nodelay=True),
            listen("robot/gripped", Bool, self._on_gripped, by.robot),
            listen("rst_control/trocar", PointStamped, self._on_trocar, by.controller),
        ]

    def step(self, wait: float) -> None:
        """Take in the joint states that came since, and publish what the newest say.

        Args:
            wait: For how long, where none came [s].

        Raises:
            RstError: A joint is missing, or has no effort.
            ValueError: A number that is none.
        """
        self._news.wait(wait)
        self._news.clear()
        trocar, found = self._trocar, None
        if trocar is None:
            self._say("the trocar is not known yet")
            return
        for _ in range(len(self._readings)):
            joints, taken = self._readings.popleft()
            found = self._estimator.update(self._measurement(joints, taken), trocar)
        if time.monotonic() - self._arrived > OLD:
            self._say("joint states are missing")
        elif found is not None:
            self._publish(joints, found)

    def _measurement(self, joints: JointState, taken: float) -> Measurement:
        """Joint states in the order of JOINTS.

        Raises:
            RstError: A joint is missing, or has no effort.
        """
        rows: dict[str, Vector] = {}
        for row in ("position", "velocity", "effort"):
            values = dict(zip(joints.name, getattr(joints, row), strict=False))
            missing = [name for name in JOINTS if name not in values]
            if missing:
                raise RstError(f"joint states without {row} of {', '.join(missing)}")
            rows[row] = np.array([values[name] for name in JOINTS])
        return Measurement(
            rows["position"], rows["velocity"], rows["effort"], taken, gripped=self._is_gripped
        )

    def _publish(self, joints: JointState, found: TensionEstimate) -> None:
        message = WrenchStamped()
        message.header.stamp, message.header.frame_id = joints.header.stamp, BASE
        force = message.wrench.force
        force.x, force.y, force.z = found.force
        if found.tension_invalid_reason:
            self._say(found.tension_invalid_reason)  # before the invalid tension
        self._tension.publish(message)
        self._say(found.tension_invalid_reason)

    def refuse(self, why: str) -> None:
        """Say that the newest joint states cannot be used."""
        self._say(why)

    def _say(self, invalid: str) -> None:
        if invalid != self._said:
            self._said = invalid
            self._invalid_reason.publish(String(invalid))

    def _on_joints(self, message: JointState) -> None:
        self._arrived = time.monotonic()
        taken = self._times.of(message.header.stamp.to_sec(), self._arrived)
        if not 0.0 <= taken - self._taken < self._min_period:
            self._readings.append((message, taken))
            self._taken = taken
            self._news.set()

    def _on_gripped(self, message: Bool) -> None:
        self._is_gripped = message.data

    def _on_trocar(self, message: PointStamped) -> None:
        self._trocar = np.array([message.point.x, message.point.y, message.point.z])


def main() -> None:
    """Run the node."""
    with starting("torque_tension", __doc__, refusals=(ConfigError, RstError)):
        settings = launch_settings()
        scene = load_config(SceneConfig, settings.pop("scene", {}), "torque_tension: scene")
        config = load_config(TorqueTensionConfig, settings, "torque_tension parameters")
        node = TorqueTensionNode(config, robot_description(), scene)
    warn_of_listeners()
    ask_for_priority()  # a tension that comes late stops the robot
    pace = 1.0 / config.rate
    while not rospy.is_shutdown():
        node.known.publish_status()
        try:
            node.step(pace)
        except (RstError, ValueError) as error:  # a message that cannot be used: say so, go on
            node.refuse(str(error))
