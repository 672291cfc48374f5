# SPDX-License-Identifier: BSD-3-Clause
"""What the rostests share: a client that speaks by ROS alone, and how they begin and end."""

from __future__ import annotations

import os
import signal
import sys
import time
import unittest
from collections.abc import Sequence

import rospy
import rostest
from geometry_msgs.msg import WrenchStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Empty
from std_srvs.srv import Trigger

from rst_control.msg import ControllerState, Event
from rst_control.srv import Command
from support.raw_peer import process_of
from support.waiting import PATIENCE

START_LIMIT = PATIENCE  # [s] for the simulator and the compiled kernels to come up
STATE_RATE = 50.0  # [Hz] of rst_control/state, in controller.yaml
MOVING = 5e-3  # [rad/s] of the fastest joint of a robot that moves
RESTING = 1e-3  # [rad/s] of one at rest, at most
HOMED = "/tool_is_homed_by_tests"  # parameter


class Halted(AssertionError):
    """A motion that had to be carried out ended with the robot holding."""


class RobotClient:
    """Calls the command service and watches what the robot does about it."""

    def __init__(self) -> None:
        self.state: ControllerState | None = None
        self.joints: JointState | None = None
        self.tension = 0.0
        self.states: list[ControllerState] = []
        self.count = 0  # of all states so far
        self.events: list[Event] = []
        self._subscribers = [
            rospy.Subscriber("rst_control/state", ControllerState, self._on_state),
            rospy.Subscriber("rst_control/event", Event, self.events.append),
            rospy.Subscriber("joint_states", JointState, self._on_joints, tcp_nodelay=True),
            rospy.Subscriber("robot/tension", WrenchStamped, self._on_tension),
        ]
        rospy.wait_for_service("rst_control/command", START_LIMIT)
        self.command = rospy.ServiceProxy("rst_control/command", Command)
        self.stop_topic = rospy.Publisher("rst_control/stop", Empty, queue_size=1)
        self.wait(lambda: self.state is not None and self.joints is not None, START_LIMIT)

    def _on_state(self, message: ControllerState) -> None:
        self.state = message
        self.states.append(message)
        self.count += 1

    def _on_joints(self, message: JointState) -> None:
        self.joints = message

    def _on_tension(self, message: WrenchStamped) -> None:
        force = message.wrench.force
        self.tension = (force.x**2 + force.y**2 + force.z**2) ** 0.5

    def wait(self, condition, limit: float = PATIENCE, every: float = 0.01) -> None:
        """Wait until the condition holds; fail with the controller's state where it never does.

        Args:
            condition: Asked again and again.
            limit: Longest wait [s], by the states of a controller that runs at its rate. One that
                the machine holds up, or that has ended, is given `PATIENCE` as well.
            every: Time between two questions [s].
        """
        count, end = self.count + limit * STATE_RATE, time.monotonic() + max(limit, PATIENCE)
        while not condition():
            if self.count > count or time.monotonic() > end:
                raise AssertionError(
                    f"waited {limit} s in vain; the controller says:\n{self.state}"
                )
            time.sleep(every)

    def wait_for_state(self, *names: str, limit: float = 30.0) -> None:
        """Wait until the controller is in one of the named states."""
        self.wait(lambda: self.state.state in names, limit)

    def say(self, command: str) -> str:
        """Give a command that must be accepted; returns its message."""
        reply = self.command(command)
        assert reply.accepted, f"{command!r} was refused: {reply.message}"
        return reply.message

    def say_and_finish(self, command: str, limit: float = 30.0) -> None:
        """Give a motion command and wait until it was carried out.

        Raises:
            Halted: The robot halted on the way, or gave the motion up.
        """
        count, halts = self.finished(command), len(self.halts())
        self.say(command)
        self.finish(command, count, halts, limit)

    def finish(self, command: str, count: int, halts: int, limit: float) -> None:
        """Wait until it was carried out more often than `count`.

        Raises:
            Halted: The robot halted on the way, or gave it up, more often than `halts`.
        """
        self.wait(lambda: self.finished(command) > count or len(self.halts()) > halts, limit)
        if self.finished(command) == count:
            raise Halted(f"{command!r} was not carried out: {self.halts()[-1]}")
        ends = [e for e in self.events if e.kind == "motion_finished" and e.command == command]
        stamp, joints = ends[-1].header.stamp, self.joints
        self.wait(lambda: self.state.header.stamp >= stamp and self.joints is not joints)
        rospy.sleep(0.1)  # for the tension of that moment to arrive

    def halts(self) -> list[str]:
        """Why it halted, or gave a motion up, each time so far."""
        return [e.message for e in self.events if e.kind in ("halted", "at_rest")]

    def finished(self, command: str) -> int:
        """How often a command was carried out to its end."""
        return sum(e.kind == "motion_finished" and e.command == command for e in self.events)

    def refused(self, command: str) -> str:
        """Give a command that must be refused; returns the reason."""
        reply = self.command(command)
        assert not reply.accepted, f"{command!r} was accepted: {reply.message}"
        return reply.message

    def activate(self) -> None:
        """Say "hey robot" until the robot is healthy and listens, as every session begins.

        Not so often that the caller's budget of calls is spent when the next command comes.
        """
        self.wait(lambda: self.command("hey robot").accepted, START_LIMIT, every=0.1)
        self.wait_for_state("active", "moving")

    def wait_for_motion(self) -> None:
        """Wait until the robot itself moves by what was accepted."""
        self.wait(lambda: self.state.state == "moving" and self.speed() > MOVING)

    def wait_for_rest(self) -> None:
        """Wait until the robot itself is at rest, whatever the controller says."""
        self.wait(lambda: self.speed() < RESTING)

    def home_tool(self) -> None:
        """Home the tool, as a person does before a session; once for all tests of a system."""
        if rospy.has_param(HOMED):
            return
        home = rospy.ServiceProxy("robot/home_tool", Trigger)
        home.wait_for_service(START_LIMIT)
        self.wait(lambda: home().success, START_LIMIT)
        rospy.set_param(HOMED, True)

    def start_fresh(self) -> None:
        """Bring the robot to rest, active, with nothing grasped, whatever the last test left."""
        self.wait_for_state("standby", "active", "halted", "faulted")
        self.activate()
        if self.state.tissue_held:
            self.say_and_finish("release")
        self.wait_for_rest()

    def leave(self) -> None:
        """Leave the robot as it was found: in standby, with nothing grasped."""
        self.start_fresh()
        self.say("terminate")
        self.wait_for_state("standby")

    def speed(self) -> float:
        """Largest measured joint speed [rad/s]."""
        return max(abs(v) for v in self.joints.velocity)

    def measured(self) -> tuple[float, ...]:
        """Joint positions [rad] that come after this call, so never those of a robot that died."""
        last = self.joints
        self.wait(lambda: self.joints is not last)
        return self.joints.position

    def drift(self, seconds: float) -> float:
        """Largest change of a joint within a time [rad]."""
        before = self.measured()
        rospy.sleep(seconds)
        return apart(before, self.measured())

    def away(self, place: Sequence[float]) -> float:
        """Largest distance of a joint from where it was [rad]."""
        return apart(place, self.joints.position)

    def max_rcm_error(self) -> float:
        """Largest RCM error that the controller reported while in motion [m]."""
        moving = [s.rcm_error for s in self.states if s.state in ("moving", "stopping")]
        return max(moving, default=0.0)


def apart(one: Sequence[float], other: Sequence[float]) -> float:
    """Largest difference of a joint between two places [rad]."""
    return max(abs(a - b) for a, b in zip(one, other, strict=True))


def kill(node: str) -> None:
    """End a node as a crash does; a launch starts most of them again."""
    os.kill(process_of(node), signal.SIGKILL)


class RobotTest(unittest.TestCase):
    """Tests that run in the order of their names and build on one robot, left as it was found."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.robot = RobotClient()

    @classmethod
    def tearDownClass(cls) -> None:
        cls.robot.leave()


def run_tests(tests: type[unittest.TestCase] | str, node: str) -> None:
    """Run the tests of a class, or of the suite of that name, as a node of this name."""
    rospy.init_node(node)
    rostest.rosrun("rst_control", node, tests, sys.argv)
