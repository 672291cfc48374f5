# SPDX-License-Identifier: BSD-3-Clause
"""The CRTK node: state, pose and twist of the arm; its state commands as those of any caller.

It has no way of its own to the robot: it brakes by the stop topic, as anybody may, and asks for all
else by the service `rst_control/command`.
"""

from __future__ import annotations

import re
import threading
import time
from contextlib import suppress
from queue import Empty, Full, Queue

import numpy as np
import rospy
from crtk_msgs.msg import StringStamped
from crtk_msgs.msg import operating_state as operating_state_message
from geometry_msgs.msg import PoseStamped, TwistStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Empty as EmptyMessage
from std_msgs.msg import Header

from rst_control.config.crtk import CRTK_FILE, CrtkConfig
from rst_control.errors import RobotModelError
from rst_control.kinematics.robot_model import RobotModel, parse_robot
from rst_control.msg import ControllerState
from rst_control.robot.crtk import OperatingState, measured_tip, operating_state, state_command
from rst_control.ros.common.pose_message import pose_message
from rst_control.ros.common.republisher import Repeated
from rst_control.srv import Command
from rst_control.types import BASE, JOINTS, Vector
from typed_config import ConfigError
from typed_config.priority import set_priority
from typed_config.ros.known_publishers import KnownPublishers
from typed_config.ros.private_settings import private_settings, robot_description
from typed_config.ros.service_calls import call_service
from typed_config.ros.starting import starting

NICE = 5  # it only shows
ARM = "gen3"  # name space of CRTK's topics, where none is given
NAME_SPACE = r"/?[A-Za-z]\w*(/[A-Za-z]\w*)*"
WAITING = 5  # commands; of more the newest are refused
ANSWER_WITHIN = 2.0  # [s] for the controller's service to be there, and to answer
PERIOD = 0.05  # [s] between two looks at the state
ENDS = state_command("disable").command  # waits on, whatever stops the robot after it
DROPPED = "dropped, since a command that stops the robot came after it"
MAYBE_OLD = (
    "refused; it is latched and may be from before this connection: give it again, or a stamp"
)
STOPPED_AGAIN = "undone by a stop, since a command that stops the robot came after it"
NEW = 1.0  # [s] age up to which a stamp shows that a latched command is new
AGAIN = 1.0  # [s] after which an unchanged state is sent anew


class CrtkNode:
    """Joins the controller's topics and service with CRTK's, which lie below `arm`.

    Args:
        config: Rates and ages.
        model: The robot.
        arm: Name space of CRTK's topics, such as "gen3".
    """

    def __init__(self, config: CrtkConfig, model: RobotModel, arm: str) -> None:
        self._config, self._model = config, model
        self._state = ControllerState()
        self._state_at = self._joints_at = self._shown_at = float("-inf")
        self._published: Repeated[OperatingState] = Repeated(AGAIN)
        self._commands: Queue[tuple[str, int]] = Queue(WAITING)  # and the brakes before
        self._brakes = 0  # commands so far that stop the robot
        self._newest: dict[str, object] = {}  # by client, header of its newest connection
        latched = {"queue_size": 10, "latch": True}
        self._operating_state = rospy.Publisher(
            f"{arm}/operating_state", operating_state_message, **latched
        )
        self._pose = rospy.Publisher(f"{arm}/measured_cp", PoseStamped, queue_size=1)
        self._twist = rospy.Publisher(f"{arm}/measured_cv", TwistStamped, queue_size=1)
        self._warning = rospy.Publisher(f"{arm}/warning", StringStamped, queue_size=10)
        self._stop = rospy.Publisher("rst_control/stop", EmptyMessage, queue_size=10)
        self._known, by, newest = KnownPublishers(), config.believed, {"queue_size": 1}
        known, command = self._known.subscribe, f"{arm}/state_command"
        self._subscribers = [
            rospy.Subscriber(command, StringStamped, self._on_brake),  # first: anybody may stop
            known(command, StringStamped, self._on_command, by.clients),
            known("rst_control/state", ControllerState, self._on_state, by.controller, **newest),
            known("joint_states", JointState, self._on_joints, by.robot, **newest),
        ]

    def run(self) -> None:
        """Publish the state until ROS shuts down; commands are given in a thread of their own."""
        threading.Thread(target=self._give_all, name="commands", daemon=True).start()
        while not rospy.is_shutdown():
            self._publish_state()
            self._known.publish_status()
            time.sleep(PERIOD)

    # --- from the threads of rospy

    def _on_state(self, message: ControllerState) -> None:
        self._state, self._state_at = message, time.monotonic()

    def _on_brake(self, message: StringStamped) -> None:
        if not state_command(message.string).brakes:
            return
        self._stop.publish(EmptyMessage())
        self._brakes += 1
        waiting: list[str] = []
        with suppress(Empty):  # said before; what ends assistance still counts
            while True:
                waiting.append(self._commands.get_nowait()[0])
        for command in dict.fromkeys(waiting):
            if command == ENDS:
                self._commands.put_nowait((command, self._brakes))
            else:
                self._warn(f"{command}: {DROPPED}")

    def _on_command(self, message: StringStamped) -> None:
        follows, may_be_old = state_command(message.string), self._may_be_old(message)
        if follows.refusal:
            self._warn(follows.refusal)
        elif may_be_old and not follows.brakes:
            self._warn(f"{message.string}: {MAYBE_OLD}")
        elif follows.command:
            try:
                self._commands.put_nowait((follows.command, self._brakes))
            except Full:
                self._warn(f"{message.string}: refused; {WAITING} commands wait already")

    def _may_be_old(self, message: StringStamped) -> bool:
        """Whether it may be of any age: the first of a connection, without a stamp, and latched.

        A publisher that latches sends its newest command to each new connection, as where this node
        was started again. A person may have stopped the robot since.
        """
        header = getattr(message, "_connection_header", None) or {}
        name = header.get("callerid", "")
        is_first = self._newest.get(name) is not header
        self._newest[name] = header
        is_new = abs(rospy.get_time() - message.header.stamp.to_sec()) <= NEW
        return is_first and header.get("latching") == "1" and not is_new

    def _on_joints(self, message: JointState) -> None:
        now = time.monotonic()
        if now - self._shown_at < 0.9 / self._config.rate:
            self._joints_at = now
            return
        try:
            joints, speeds = (_in_order(message, row) for row in ("position", "velocity"))
        except ValueError as error:
            rospy.logwarn_throttle(10.0, "crtk: %s", error)
            return
        self._joints_at = self._shown_at = now
        pose, twist = measured_tip(self._model, joints, speeds)
        header = Header(stamp=message.header.stamp, frame_id=BASE)
        self._pose.publish(PoseStamped(header, pose_message(pose)))
        moving = TwistStamped(header=header)
        moving.twist.linear.x, moving.twist.linear.y, moving.twist.linear.z = twist[:3]
        moving.twist.angular.x, moving.twist.angular.y, moving.twist.angular.z = twist[3:]
        self._twist.publish(moving)

    # --- from threads of the node's own

    def _publish_state(self) -> None:
        """The state, where it changed or was not sent for a while."""
        now, limit = time.monotonic(), self._config.old_after
        is_heard, is_measured = now - self._state_at < limit, now - self._joints_at < limit
        state = self._state.state if is_heard else ""
        found = operating_state(state, self._state.assistance_enabled, is_measured)
        if not self._published.is_due(found, now):
            return
        message = operating_state_message()
        message.header.stamp = rospy.Time.now()
        message.state, message.is_homed = found.state, found.is_homed
        message.is_busy = found.is_busy
        self._operating_state.publish(message)

    def _give_all(self) -> None:
        while not rospy.is_shutdown():
            with suppress(Empty):
                self._give(*self._commands.get(timeout=1.0))

    def _give(self, command: str, brakes: int) -> None:
        """Ask the controller, as any caller; a refusal goes to CRTK's `warning`.

        What it does not take in time is never sent: it would count whenever the controller wakes.
        """

        def is_void() -> bool:
            return brakes != self._brakes and command != ENDS

        reply = call_service(
            "rst_control/command",
            Command,
            command,
            within=ANSWER_WITHIN,
            appears=ANSWER_WITHIN,
            is_void=is_void,
        )
        answer = reply.response
        if is_void() and (reply.may_take_effect or (answer is not None and answer.accepted)):
            self._stop.publish(EmptyMessage())  # it may have come after the stop
            self._warn(f"{command}: {STOPPED_AGAIN}")
        elif answer is None:
            self._warn(f"{command}: {DROPPED if is_void() else reply.trouble}")
        elif not answer.accepted:
            self._warn(f"{command}: refused; {answer.message}")

    def _warn(self, words: str) -> None:
        rospy.logwarn("crtk: %s", words)
        message = StringStamped(string=words)
        message.header.stamp = rospy.Time.now()
        self._warning.publish(message)


def _in_order(message: JointState, row: str) -> Vector:
    """One row of joint states in the order of JOINTS.

    Raises:
        ValueError: A joint is missing, or a number is none.
    """
    values = dict(zip(message.name, getattr(message, row), strict=False))
    missing = [name for name in JOINTS if name not in values]
    if missing:
        raise ValueError(f"joint states without {row} of {', '.join(missing)}")
    found = np.array([values[name] for name in JOINTS], np.float64)
    if not np.isfinite(found).all():
        raise ValueError(f"joint states with a {row} that is no number")
    return found


def _arm(name: object) -> str:
    """Name space of CRTK's topics.

    Raises:
        ConfigError: It is none.
    """
    if not isinstance(name, str) or not re.fullmatch(NAME_SPACE, name):
        raise ConfigError("arm", name, f"letters, digits, _ and /, such as {ARM}")
    return name


def main() -> None:
    """Run the CRTK node."""
    set_priority(NICE)
    with starting("crtk", __doc__, refusals=(ConfigError, RobotModelError)):
        config = private_settings(CrtkConfig, CRTK_FILE)
        model = parse_robot(robot_description())
        node = CrtkNode(config, model, _arm(rospy.get_param("~arm", ARM)))
    node.run()
