# SPDX-License-Identifier: BSD-3-Clause
"""The robot as the controller reaches it: set-points out; joint states, tension, grip, faults in.

Callbacks only keep the newest bytes; the loop reads them when it needs them. `MeasurementAssembler`
says which of them are believed.
"""

from __future__ import annotations

import time

import rospy
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Empty, String

from rst_control.commands.parser import shown
from rst_control.config import WatchdogConfig
from rst_control.config.believed import BelievedConfig
from rst_control.robot.backend import RobotBackend
from rst_control.ros.common.raw_messages import RawJointState, RawWrench, WrittenJointState
from rst_control.ros.common.serialization import write_joint_state
from rst_control.ros.common.wall_clock import RosClock
from rst_control.ros.controller.measurement_assembler import MeasurementAssembler
from rst_control.types import JOINTS, Measurement, Setpoint
from typed_config.ros.known_publishers import KnownPublishers

FORMER_TOPIC = "robot/tension_distrust"  # what is sent there makes the tension invalid
LONGEST_FAULT = 200  # characters of what the robot says is wrong with it


class RobotLink(RobotBackend):
    """The robot behind its topics. Only the loop's thread reads and sends.

    Args:
        clock: Makes stamps.
        watchdogs: How old messages may be.
        tension: Where the tension comes from, as `tension.source` says.
        known: Makes the subscribers.
        believed: Nodes whose messages count.
    """

    def __init__(
        self,
        clock: RosClock,
        watchdogs: WatchdogConfig,
        tension: str,
        known: KnownPublishers,
        believed: BelievedConfig,
    ) -> None:
        self._clock, self._has_tension = clock, tension != "none"
        self._assembler = MeasurementAssembler(watchdogs, time.monotonic, tension)
        self._sent = 0
        self._servo = rospy.Publisher("robot/servo_jp", JointState, queue_size=1, tcp_nodelay=True)
        self._hold = rospy.Publisher("robot/hold", Empty, queue_size=1, tcp_nodelay=True)
        self._clear = rospy.Publisher("robot/clear_fault", Empty, queue_size=1, tcp_nodelay=True)
        newest = {"tcp_nodelay": True, "queue_size": 1}  # of what piles up on one connection
        robot, tension_by = believed.robot, believed.tension
        self._subscribers = [
            known.subscribe("joint_states", RawJointState, self._on_joints, robot, **newest),
            known.subscribe("robot/tension", RawWrench, self._on_wrench, tension_by, **newest),
            known.subscribe(
                "robot/tension_invalid_reason", String, self._on_tension_invalid, tension_by
            ),
            known.subscribe(FORMER_TOPIC, String, self._on_former_topic, tension_by),
            known.subscribe("robot/setpoint_js", RawJointState, self._on_rest, robot, **newest),
            known.subscribe("robot/gripped", Bool, self._on_gripped, robot, **newest),
            known.subscribe("robot/fault", String, self._on_fault, robot, **newest),
        ]

    def measured_js(self) -> Measurement | None:
        """Newest joint states with the force on the jaws; None while the robot never spoke."""
        return self._assembler.measured()

    @property
    def objection(self) -> str:
        """What is wrong with the robot's messages; empty: nothing."""
        return self._assembler.objection

    def servo_jp(self, setpoint: Setpoint) -> None:
        """Send one set-point."""
        self._sent += 1
        self._assembler.led()
        stamp = self._clock.stamp(setpoint.stamp)
        raw = write_joint_state(
            (self._sent, stamp.secs, stamp.nsecs), JOINTS, setpoint.position, setpoint.velocity
        )
        self._servo.publish(WrittenJointState(raw))

    def hold(self) -> None:
        """Let the robot slow down and stay."""
        self._hold.publish(Empty())

    def clear_fault(self) -> None:
        """Ask the robot to take set-points again."""
        self._clear.publish(Empty())

    def _on_joints(self, message: RawJointState) -> None:
        message.ahead = self._clock.ahead()
        self._assembler.joints = message

    def _on_wrench(self, message: RawWrench) -> None:
        self._assembler.wrench = message

    def _on_tension_invalid(self, message: String) -> None:
        if self._has_tension:
            self._assembler.tension_invalid_reason = shown(message.data, LONGEST_FAULT)

    def _on_former_topic(self, _: String) -> None:
        words = f"{FORMER_TOPIC} has another name: robot/tension_invalid_reason"
        self._on_tension_invalid(String(words))

    def _on_rest(self, message: RawJointState) -> None:
        self._assembler.rest = message

    def _on_gripped(self, message: Bool) -> None:
        self._assembler.gripped = message.data

    def _on_fault(self, message: String) -> None:
        self._assembler.fault = shown(message.data, LONGEST_FAULT)
