# SPDX-License-Identifier: BSD-3-Clause
"""The fast way to the simulated robot: set-points in; joints, tension, grip and faults out."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Sequence

import numpy as np
import rospy
from geometry_msgs.msg import WrenchStamped
from numpy.typing import NDArray
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Empty, String

from rst_control.config.plant import LatenessConfig
from rst_control.ros.common.raw_messages import RawJointState, WrittenJointState, WrittenWrench
from rst_control.ros.common.republisher import Repeated
from rst_control.ros.common.serialization import BadMessage, JointStateReader
from rst_control.ros.common.wall_clock import ArrivalOffset
from rst_control.ros.simulator.messages import Stamper, StateWriter
from rst_control.simulation.plant.lateness import LateQueue
from rst_control.simulation.pybullet_robot import PybulletRobot
from rst_control.types import JOINTS, Cause, Reason, Setpoint, robot_fault
from typed_config.ros.known_publishers import KnownPublishers

log = logging.getLogger("rosout.rst_control.simulator")

MAX_JOBS = 1000  # that wait for the loop; set-points beyond are missed, and the servo holds
REPEAT_PERIOD = 0.5  # [s] between words on grip and fault where they stay the same
NO_STAMP = 0.0  # set-points sent by hand carry no stamp


class SetpointInterface:
    """Takes set-points and publishes states, 500 of each in a second.

    Args:
        robot: What is simulated.
        jobs: What the simulator's loop does between two steps.
        stamper: Time of the messages.
        is_real_time: Whether stamps of others are on the same clock.
        known: Makes the subscribers.
        led_by: Nodes that may lead the robot.
        lateness: Of what comes and goes.
        seed: Of its jitter.
    """

    def __init__(
        self,
        robot: PybulletRobot,
        jobs: deque[Callable[[], None]],
        stamper: Stamper,
        is_real_time: bool,
        known: KnownPublishers,
        led_by: Sequence[str],
        lateness: LatenessConfig,
        seed: int,
    ) -> None:
        self._robot, self._jobs = robot, jobs
        self._ahead = ArrivalOffset(stamper.ahead)  # of set-points
        self._is_real_time = is_real_time
        self._writer, self._reader = StateWriter(stamper), JointStateReader(JOINTS)
        random = np.random.default_rng(seed)
        self._commands: LateQueue[Setpoint] = LateQueue(
            lateness.command_delay, lateness.command_jitter, random
        )
        self._feedback: LateQueue[tuple[WrittenJointState, WrittenWrench]] = LateQueue(
            lateness.feedback_delay, lateness.feedback_jitter, random
        )
        self._last_grip: Repeated[bool] = Repeated(REPEAT_PERIOD)
        self._last_fault: Repeated[str] = Repeated(REPEAT_PERIOD)
        self._last_rest: Repeated[NDArray[np.float64]] = Repeated(REPEAT_PERIOD, np.array_equal)
        self._joints = rospy.Publisher("joint_states", JointState, queue_size=5, tcp_nodelay=True)
        self._tension = rospy.Publisher(
            "robot/tension", WrenchStamped, queue_size=5, tcp_nodelay=True
        )
        self._rest = rospy.Publisher("robot/setpoint_js", JointState, queue_size=10, latch=True)
        self._gripped = rospy.Publisher("robot/gripped", Bool, queue_size=10, latch=True)
        self._fault = rospy.Publisher("robot/fault", String, queue_size=10, latch=True)
        self._subscribers = [
            known.subscribe(
                "robot/servo_jp", RawJointState, self._on_setpoint, led_by, tcp_nodelay=True
            ),
            known.subscribe("robot/hold", Empty, self._on(robot.hold), led_by, queue_size=1),
            known.subscribe(
                "robot/clear_fault", Empty, self._on(robot.clear_fault), led_by, queue_size=1
            ),
        ]

    def lead(self) -> None:
        """Hand set-points that have arrived to the robot."""
        for setpoint in self._commands.take(self._robot.now):
            self._robot.servo_jp(setpoint)

    def publish(self) -> None:
        """Publish the state of the robot."""
        robot, now = self._robot, self._robot.now
        joints = self._writer.joints(now, robot.reading)
        self._feedback.put((joints, self._writer.wrench(now, robot.force)), now)
        for joints, wrench in self._feedback.take(now):
            self._joints.publish(joints)
            self._tension.publish(wrench)
        rest = robot.rest
        if rest is not None and self._last_rest.is_due(rest, now):
            self._rest.publish(self._writer.rest(now, rest))
        if self._last_grip.is_due(robot.tissue.is_held, now):
            self._gripped.publish(Bool(robot.tissue.is_held))
        before, fault = self._last_fault.last, robot.fault
        if self._last_fault.is_due(fault, now):
            if fault and fault != before:
                log.warning("fault: %s", robot_fault(fault).words)
            self._fault.publish(String(fault))

    def _on(self, job: Callable[[], None]) -> Callable[[Empty], None]:
        return lambda _: self._jobs.append(job)

    def _on_setpoint(self, message: RawJointState) -> None:
        if len(self._jobs) < MAX_JOBS:
            ahead = self._ahead()
            if ahead is not None:
                self._jobs.append(lambda: self._take(message.raw, ahead))

    def _take(self, raw: bytes, ahead: float) -> None:
        self._reader.reset()  # the servo itself judges the order of stamps
        try:
            sample = self._reader(raw)
        except BadMessage as error:
            words = f"bad set-point: {error}"
            self._robot.fail(Cause(Reason.SETPOINT_REFUSED, words).coded)
            return
        known = self._is_real_time and sample.stamp > NO_STAMP
        stamp = sample.stamp - ahead if known else self._robot.now
        setpoint = Setpoint(sample.position, sample.velocity, stamp)
        self._commands.put(setpoint, self._robot.now)
