# SPDX-License-Identifier: BSD-3-Clause
"""The drivers of arm and tool by ROS: what they are sent, and what they report."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future

import rospy
from kortex_driver.msg import Base_JointSpeeds, BaseCyclic_Feedback, JointSpeed
from openrst_control.srv import openrst_request
from sensor_msgs.msg import JointState
from std_msgs.msg import Empty, Float64MultiArray, Int32MultiArray

from rst_control.kinova.arm_state import ArmReport
from rst_control.kinova.brake_plan import BrakePlan
from rst_control.kinova.config import BridgeConfig
from rst_control.kinova.feedback import BadFeedback, FeedbackReader, JointFeedback, rows_of
from rst_control.kinova.homing import HomingFailed, answered
from rst_control.ros.kinova.arm_report import LOST_CONNECTION, read_report
from rst_control.types import Vector
from typed_config.ros.known_publishers import KnownPublishers

LAST_TIMES, LAST_PERIOD = 5, 0.02  # that a last message is sent, and [s] between them
LOOK_PERIOD = 0.002  # [s] between two looks whether a velocity is due
SAY_AGAIN = 2.0  # [s] before the same complaint about messages is made again


def send_at_shutdown(send: Callable[[], None]) -> None:
    """Send what must arrive before this process ends, more than once."""
    for _ in range(LAST_TIMES):
        send()
        time.sleep(LAST_PERIOD)


def speeds_message(speeds: Vector) -> Base_JointSpeeds:
    """Joint speeds [rad/s] as the arm's driver takes them. Shape (7,)."""
    joints = [JointSpeed(j, speed, 0) for j, speed in enumerate(speeds.tolist())]
    return Base_JointSpeeds(joints, 0)


class KinovaHardware:
    """A `Hardware` that speaks ROS.

    Args:
        config: Names of the drivers and of their joints.
        first_turns: Of the arm's joints [rad], for `FeedbackReader`. Shape (7,).
        known: Makes the subscribers.
    """

    def __init__(
        self, config: BridgeConfig, first_turns: Sequence[float], known: KnownPublishers
    ) -> None:
        self._first_turns = first_turns
        arm, tool = config.arm.namespace, config.tool.namespace
        self._config, self._known, self._is_closed = config, known, False
        newest = {"queue_size": 1, "tcp_nodelay": True}
        self._speeds = rospy.Publisher(f"{arm}/in/joint_velocity", Base_JointSpeeds, **newest)
        self._stop = rospy.Publisher(f"{arm}/in/stop", Empty, **newest)
        self._clear = rospy.Publisher(f"{arm}/in/clear_faults", Empty, **newest)
        self._tool = rospy.Publisher(
            f"{tool}/effort_controller/command", Float64MultiArray, **newest
        )
        self._asked, self._answer = "", Future[bool]()  # the last request to OpenRST
        self._answer.set_result(True)

    def send_speeds(self, speeds: Vector) -> None:
        """Turn the arm's joints at these speeds [rad/s]. Shape (7,)."""
        if not self._is_closed:
            self._speeds.publish(speeds_message(speeds))

    def send_tool(self, joints: Vector) -> None:
        """Send pitch and jaws to these angles [rad]. Shape (3,)."""
        self._tool.publish(Float64MultiArray(data=joints.tolist()))

    def stop(self) -> None:
        """Stop the arm."""
        self._stop.publish(Empty())

    def clear_faults(self) -> None:
        """Ask the arm to clear its faults."""
        self._clear.publish(Empty())

    def close(self, plan: BrakePlan | None, beat: Callable[[], None]) -> None:
        """Brake the arm along its course, where it is led, stop it, and send no more velocities.

        Args:
            plan: How to brake; None: the arm is not led.
            beat: Says to the guard that somebody else brakes.
        """
        self._is_closed = True  # for the loop, which may be in the midst of a round
        while plan is not None and not plan.is_over:
            if (speeds := plan.step(time.monotonic())) is not None:
                self._speeds.publish(speeds_message(speeds))
            beat()
            time.sleep(LOOK_PERIOD)

        def stop() -> None:
            self.stop()
            beat()

        send_at_shutdown(stop)

    def request(self, message: str) -> bool:
        """Ask OpenRST's node for something, and wait for the answer.

        Raises:
            rospy.ROSException: There is no such node.
            HomingFailed: The node does not know it, or died, or there was no answer within
                `tool.homing_limit`. Then the node goes on, because nothing ends its homing where
                the instrument does not engage. So nothing else is asked until it has answered.
        """
        if not self._answer.done():
            raise HomingFailed(self._asked, "is still not answered: end OpenRST's node")
        name, limit = f"{self._config.tool.namespace}/openrst_request", 5.0
        rospy.wait_for_service(name, limit)
        answer = Future[bool]()
        self._asked, self._answer = message, answer

        def ask() -> None:
            try:
                answer.set_result(rospy.ServiceProxy(name, openrst_request)(message).succeeded)
            except (rospy.ServiceException, rospy.ROSException, *LOST_CONNECTION) as error:
                answer.set_exception(HomingFailed(message, f"was not answered: {error}"))

        threading.Thread(target=ask, name="openrst_request", daemon=True).start()
        return answered(answer, message, self._config.tool.homing_limit)

    def listen(
        self,
        on_arm: Callable[[JointFeedback], None],
        on_tool: Callable[[JointFeedback], None],
        on_tool_state: Callable[[int], None],
        on_report: Callable[[ArmReport], None],
    ) -> None:
        """Begin to hand over what the drivers report, from threads of rospy."""
        arm, tool = self._config.arm, self._config.tool
        newest = {"queue_size": 1, "tcp_nodelay": True}
        reader = FeedbackReader(arm.joints, (1.0,) * len(arm.joints), self._first_turns)
        known, by = self._known.subscribe, self._config.believed
        self._subscribers = [
            known(
                f"{arm.namespace}/base_feedback",
                BaseCyclic_Feedback,
                lambda message: on_report(read_report(message, time.monotonic())),
                by.arm,
                **newest,
            ),
            known(
                f"{arm.namespace}/base_feedback/joint_state",
                JointState,
                _to(reader, on_arm),
                by.arm,
                **newest,
            ),
            known(
                f"{tool.namespace}/joint_states",
                JointState,
                _to(FeedbackReader(tool.joints, tool.signs, None), on_tool),
                by.tool,
                **newest,
            ),
            known(
                f"{tool.namespace}/openrst_state",
                Int32MultiArray,
                lambda message: on_tool_state(message.data[0] if message.data else -1),
                by.tool,
                **newest,
            ),
        ]


def _to(
    reader: FeedbackReader, take: Callable[[JointFeedback], None]
) -> Callable[[JointState], None]:
    def on_message(message: JointState) -> None:
        arrived = time.monotonic()
        try:
            take(reader.read(message.name, rows_of(message), arrived))
        except BadFeedback as error:  # it counts as not having come: the states grow old
            rospy.logwarn_throttle(SAY_AGAIN, str(error))

    return on_message
