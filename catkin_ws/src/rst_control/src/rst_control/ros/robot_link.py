# SPDX-License-Identifier: BSD-3-Clause
"""The robot as the controller reaches it: set-points out; joint states, tension, grip, faults in.

Callbacks only keep the newest bytes; the loop reads them when it needs them. All times are those
of the steady clock at arrival, so that a jump of the wall clock is no fault.
"""

from __future__ import annotations

import time
from dataclasses import replace
from io import BytesIO

import numpy as np
import rospy
from geometry_msgs.msg import WrenchStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Empty, String

from rst_control.ros.messages import RosClock
from rst_control.ros.wire import BadMessage, JointStateReader, read_force, write_joint_state
from rst_control.types import JOINTS, Measurement, Setpoint, Vector

LOST_AFTER = 0.25  # [s] without joint states: the robot counts as not connected
TENSION_AGE = 0.1  # [s] by which the newest tension may be older than the newest joint states
NO_EFFORT = np.zeros(len(JOINTS))


class _Raw:
    """A message left as bytes, with the time at which it came."""

    raw = b""
    arrived = 0.0

    def deserialize(self, buff: bytes) -> _Raw:
        """Keep the bytes."""
        self.raw, self.arrived = buff, time.monotonic()
        return self


class RawJointState(_Raw, JointState):
    """sensor_msgs/JointState as bytes."""

    def __init__(self) -> None:
        """Make none of the fields."""


class RawWrench(_Raw, WrenchStamped):
    """geometry_msgs/WrenchStamped as bytes."""

    def __init__(self) -> None:
        """Make none of the fields."""


class SetpointMessage(JointState):
    """sensor_msgs/JointState written from a set-point without an intermediate form."""

    _has_header = False  # the header is in the bytes, too

    def __init__(self, raw: bytes) -> None:
        self.raw = raw

    def serialize(self, buff: BytesIO) -> None:
        """Write the bytes."""
        buff.write(self.raw)


class RobotLink:
    """A RobotBackend that speaks ROS; reads and sends are for the loop's thread alone."""

    def __init__(self, clock: RosClock) -> None:
        self._clock = clock
        self._read = JointStateReader(JOINTS)
        self._joints: RawJointState | None = None
        self._seen: RawJointState | None = None
        self._wrench: RawWrench | None = None
        self._gripped, self._fault, self._objection = False, "", ""
        self._measured: Measurement | None = None
        self._sent = 0
        self._servo = rospy.Publisher("robot/servo_jp", JointState, queue_size=1, tcp_nodelay=True)
        self._hold = rospy.Publisher("robot/hold", Empty, queue_size=1, tcp_nodelay=True)
        self._clear = rospy.Publisher("robot/clear_fault", Empty, queue_size=1, tcp_nodelay=True)
        self._subscribers = [
            rospy.Subscriber("joint_states", RawJointState, self._on_joints, tcp_nodelay=True),
            rospy.Subscriber("robot/tension", RawWrench, self._on_wrench, tcp_nodelay=True),
            rospy.Subscriber("robot/gripped", Bool, self._on_gripped, tcp_nodelay=True),
            rospy.Subscriber("robot/fault", String, self._on_fault, tcp_nodelay=True),
        ]

    def measured_js(self) -> Measurement | None:
        """Newest joint states with the force on the jaws; None while the robot never spoke."""
        joints = self._joints
        if joints is not None and joints is not self._seen:
            self._seen = joints
            self._take(joints)
        else:
            self._keep()
        return self._measured

    @property
    def objection(self) -> str:
        """What is wrong with the robot's newest messages; empty: nothing."""
        return self._objection

    def servo_jp(self, setpoint: Setpoint) -> None:
        """Send one set-point."""
        self._sent += 1
        stamp = self._clock.stamp(setpoint.stamp)
        raw = write_joint_state(
            (self._sent, stamp.secs, stamp.nsecs), JOINTS, setpoint.position, setpoint.velocity
        )
        self._servo.publish(SetpointMessage(raw))

    def hold(self) -> None:
        """Let the robot slow down and stay."""
        self._hold.publish(Empty())

    def clear_fault(self) -> None:
        """Ask the robot to take set-points again."""
        self._clear.publish(Empty())

    def _take(self, joints: RawJointState) -> None:
        try:
            sample = self._read(joints.raw)
        except BadMessage as error:
            self._objection = str(error)
            self._keep()
            return
        self._objection = ""
        force = self._force(joints.arrived)
        self._measured = Measurement(
            position=sample.position,
            velocity=sample.velocity,
            effort=NO_EFFORT,
            stamp=joints.arrived,
            force=force,
            gripped=self._gripped,
            fault=self._fault or self._objection,
        )

    def _keep(self) -> None:
        """No new joint states: note what else has changed."""
        measured = self._measured
        if measured is None:
            return
        is_connected = time.monotonic() - measured.stamp < LOST_AFTER
        if not is_connected:
            self._read.reset()  # a robot that comes back may have another clock
        fault = self._fault or self._objection
        if (is_connected, fault) != (measured.connected, measured.fault):
            self._measured = replace(measured, connected=is_connected, fault=fault)

    def _force(self, arrived: float) -> Vector:
        """Newest force on the jaws; where there is none, the last one, with an objection."""
        wrench = self._wrench
        if wrench is None or arrived - wrench.arrived > TENSION_AGE:
            self._objection = "tension is not measured"
        else:
            try:
                return read_force(wrench.raw)
            except BadMessage as error:
                self._objection = str(error)
        return self._measured.force if self._measured is not None else np.zeros(3)

    def _on_joints(self, message: RawJointState) -> None:
        self._joints = message

    def _on_wrench(self, message: RawWrench) -> None:
        self._wrench = message

    def _on_gripped(self, message: Bool) -> None:
        self._gripped = message.data

    def _on_fault(self, message: String) -> None:
        self._fault = message.data
