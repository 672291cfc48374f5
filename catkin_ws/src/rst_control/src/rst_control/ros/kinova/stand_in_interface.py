# SPDX-License-Identifier: BSD-3-Clause
"""The strict way to the simulated robot: topics, action and service of the real drivers."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable

import actionlib
import numpy as np
import rospy
from control_msgs.msg import FollowJointTrajectoryAction
from geometry_msgs.msg import WrenchStamped
from kortex_driver.msg import Base_JointSpeeds, BaseCyclic_Feedback, FirmwareBundleVersions
from kortex_driver.srv import (
    GetFirmwareBundleVersions,
    GetFirmwareBundleVersionsResponse,
    GetKinematicSoftLimits,
    GetKinematicSoftLimitsResponse,
)
from openrst_control.srv import openrst_request, openrst_requestRequest, openrst_requestResponse
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Empty, Float64MultiArray, Int32MultiArray

from rst_control.config import SimulationConfig
from rst_control.kinova.arm_state import FIRMWARE_SERVICE, LIMITS_SERVICE
from rst_control.kinova.stand_in import KinovaRobot, StandInConfig
from rst_control.kinova.stand_in.simulated_robot import ArmFeedback
from rst_control.ros.common.other_provider import other_provider
from rst_control.ros.common.republisher import Due
from rst_control.ros.kinova.arm_report import read_report, written_limits, written_report
from rst_control.ros.kinova.stand_in_goals import RosGoal
from rst_control.ros.simulator.messages import Stamper, StateWriter
from rst_control.simulation.pybullet_robot import PybulletRobot

HOMING_LIMIT = 120.0  # [s] for a request to be answered
FIRMWARE = "stand-in"
REQUEST_SERVICE = "openrst_request"
ALIVE_PERIOD = 0.1  # [s] between checks whether the node ends while a request waits


def other_driver(config: StandInConfig) -> str:
    """A living node that has these drivers' services already; empty: none has.

    The two would share all commands, and the services would be those of the later one.
    """
    services = f"{config.driver.name}/{LIMITS_SERVICE}", f"{config.tool.name}/{REQUEST_SERVICE}"
    return next(filter(None, map(other_provider, services)), "")


class DriverInterface:
    """Stands in for Kinova's driver and for OpenRST's node.

    Args:
        robot: What is simulated.
        jobs: What the simulator's loop does between two steps.
        stamper: Time of the messages.
        simulation: With the layers of limits.
        config: Of the stand-in.
    """

    def __init__(
        self,
        robot: PybulletRobot,
        jobs: deque[Callable[[], None]],
        stamper: Stamper,
        simulation: SimulationConfig,
        config: StandInConfig,
    ) -> None:
        self._robot, self._jobs, self._stamper, self._config = robot, jobs, stamper, config
        self._drivers = KinovaRobot(config, simulation.limits, robot)
        self._writer = StateWriter(stamper)
        self._published_grip: bool | None = None
        self._reports = 0  # of the arm's state so far
        self._arm_due = Due(1.0 / config.driver.feedback_rate)
        self._tool_due = Due(config.tool.period)
        self._advertise()
        self._subscribe()

    def lead(self) -> None:
        """Let the drivers go on, and lead the robot."""
        self._drivers.step()

    def publish(self) -> None:
        """Publish what the drivers publish, and, by names of its own, what really is."""
        now = self._robot.now
        if self._arm_due(now):
            self._publish_arm()
        if self._tool_due(now):
            self._publish_tool()
        self._true_joints.publish(self._writer.joints(now, self._robot.reading))
        wrench = self._writer.wrench(now, self._robot.force)
        self._true_tension.publish(wrench)
        if self._force_sensor is not None:
            self._force_sensor.publish(wrench)
        if self._robot.tissue.is_held != self._published_grip:
            self._published_grip = self._robot.tissue.is_held
            self._true_grip.publish(Bool(self._published_grip))

    def _advertise(self) -> None:
        arm, tool, topic = self._config.driver.name, self._config.tool.name, rospy.Publisher
        queue = {"queue_size": 5, "tcp_nodelay": True}
        self._arm_report = topic(f"{arm}/base_feedback", BaseCyclic_Feedback, **queue)
        self._arm_feedback = topic(f"{arm}/base_feedback/joint_state", JointState, **queue)
        self._arm_states = topic(f"{arm}/joint_states", JointState, **queue)
        self._tool_states = topic(f"{tool}/joint_states", JointState, **queue)
        self._tool_state = topic(f"{tool}/openrst_state", Int32MultiArray, **queue)
        self._true_joints = topic("simulation/joint_states", JointState, **queue)
        self._true_tension = topic("simulation/tension", WrenchStamped, **queue)
        self._true_grip = topic("simulation/gripped", Bool, queue_size=10, latch=True)
        sensor = self._config.force_sensor_topic
        self._force_sensor = topic(sensor, WrenchStamped, **queue) if sensor else None

    def _subscribe(self) -> None:
        arm, tool = self._config.driver.name, self._config.tool.name
        driver, listen = self._drivers.driver, rospy.Subscriber
        empties = {
            "stop": driver.take_stop,
            "emergency_stop": driver.take_emergency_stop,
            "clear_faults": driver.take_clear_faults,
        }
        self._subscribers = [
            listen(f"{arm}/in/{name}", Empty, self._on(job), queue_size=1, tcp_nodelay=True)
            for name, job in empties.items()
        ]
        fast = {"queue_size": 1, "tcp_nodelay": True}
        self._subscribers += [
            listen(f"{arm}/in/joint_velocity", Base_JointSpeeds, self._on_speeds, **fast),
            listen(
                f"{tool}/effort_controller/command", Float64MultiArray, self._on_command, **fast
            ),
        ]
        interfered = "simulation/arm_state"
        self._subscribers.append(listen(interfered, BaseCyclic_Feedback, self._on_interference))
        limits = GetKinematicSoftLimitsResponse(written_limits(self._drivers.soft_limits()))
        firmware = GetFirmwareBundleVersionsResponse(FirmwareBundleVersions(FIRMWARE, []))
        self._services = [
            rospy.Service(f"{arm}/{LIMITS_SERVICE}", GetKinematicSoftLimits, lambda _: limits),
            rospy.Service(
                f"{arm}/{FIRMWARE_SERVICE}", GetFirmwareBundleVersions, lambda _: firmware
            ),
        ]
        self._service = rospy.Service(
            f"{tool}/{REQUEST_SERVICE}", openrst_request, self._on_request
        )
        self._server = actionlib.ActionServer(
            f"{arm}/gen3_joint_trajectory_controller/follow_joint_trajectory",
            FollowJointTrajectoryAction,
            self._on_goal,
            self._on_cancel,
            auto_start=False,
        )
        self._server.start()

    def _publish_arm(self) -> None:
        feedback = self._drivers.arm_feedback()
        if feedback is None:
            return
        self._publish_report(feedback)
        message = JointState(
            name=list(self._config.driver.joints),
            position=feedback.position.tolist(),
            velocity=feedback.velocity.tolist(),
            effort=feedback.effort.tolist(),
        )
        message.header.stamp = self._stamp()
        self._arm_feedback.publish(message)
        self._arm_states.publish(message)

    def _publish_report(self, feedback: ArmFeedback) -> None:
        report = self._drivers.arm_report()
        if report is None:
            return
        self._reports += 1
        message = written_report(report, self._reports)
        for joint, actuator in enumerate(message.actuators):
            actuator.position = float(np.degrees(feedback.position[joint])) % 360.0
            actuator.velocity = float(np.degrees(feedback.velocity[joint]))
            actuator.torque = float(feedback.effort[joint])
        self._arm_report.publish(message)

    def _publish_tool(self) -> None:
        self._tool_state.publish(Int32MultiArray(data=[int(self._drivers.tool.state)]))
        position = self._drivers.tool_feedback()
        if position is None:
            return
        nothing = [0.0] * len(position)  # the node never fills these in
        message = JointState(
            name=list(self._config.tool.joints),
            position=position.tolist(),
            velocity=nothing,
            effort=nothing,
        )
        message.header.stamp = self._stamp()
        self._tool_states.publish(message)

    def _stamp(self) -> rospy.Time:
        return rospy.Time(*self._stamper.split(self._robot.now))

    def _on(self, job: Callable[[], None]) -> Callable[[Empty], None]:
        return lambda _: self._jobs.append(job)

    def _on_interference(self, message: BaseCyclic_Feedback) -> None:
        """What happens at the arm itself, for tests: its state, until one that is ready."""
        arm = self._drivers.driver.arm
        report = read_report(message, time.monotonic())
        self._jobs.append(lambda: arm.interfere(report, self._robot.now))

    def _on_goal(self, handle: actionlib.ServerGoalHandle) -> None:
        goal = RosGoal(handle)
        self._jobs.append(lambda: self._drivers.driver.take_goal(goal))

    def _on_cancel(self, _: actionlib.ServerGoalHandle) -> None:
        self._jobs.append(self._drivers.driver.take_cancel)

    def _on_speeds(self, message: Base_JointSpeeds) -> None:
        speeds = {entry.joint_identifier: float(entry.value) for entry in message.joint_speeds}
        self._jobs.append(lambda: self._drivers.driver.take_speeds(speeds))

    def _on_command(self, message: Float64MultiArray) -> None:
        values = tuple(message.data)
        self._jobs.append(lambda: self._drivers.tool.take_command(values))

    def _on_request(self, request: openrst_requestRequest) -> openrst_requestResponse | None:
        """Answer one request; None makes the call fail, as an unknown request does there."""
        answers: list[bool] = []
        answered = threading.Event()

        def reply(succeeded: bool) -> None:
            answers.append(succeeded)
            answered.set()

        def ask() -> None:
            if not self._drivers.tool.request(request.message, reply):
                answered.set()

        self._jobs.append(ask)
        for _ in range(round(HOMING_LIMIT / ALIVE_PERIOD)):
            if answered.wait(ALIVE_PERIOD) or rospy.is_shutdown():
                break
        return openrst_requestResponse(answers[0]) if answers else None
