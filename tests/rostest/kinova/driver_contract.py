#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What the bridge relies on of the drivers of arm and tool, be they real or stood in for."""

import time
import unittest

import numpy as np
import rospy
from actionlib_msgs.msg import GoalStatus
from driver_client import MOVED, NAMES, STILL, DriverClient, wrapped
from openrst_control.srv import openrst_request
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, Int32MultiArray

from support.waiting import PATIENCE, wait_until
from tests.support.robot_client import run_tests

ANGLE = 0.007  # [rad] (0.4 deg) that one joint is moved, at most
SPEED = 0.005  # [rad/s] at which it is turned
ON = 1e-3  # [rad] that it turns on by itself
LEAST_DELAY = 1.0  # [s] between a goal and its motion
DELAY = 2.5  # [s] in which what is to move has begun to
WARNING = """
This suite moves joint_7 of {robot} by {angle:.1f} deg and back, a few times, and stops it.
No other joint is moved. {rest}"""
ON_A_ROBOT = """It will begin in {wait:.0f} s. Hold a hand on the emergency stop; Ctrl-C ends it.
Left out on a robot: joints in another order, homing of the tool."""
NO_EMERGENCY_STOP = (
    "a real arm is moved only with i_have_an_emergency_stop:=true, by somebody with a hand on it"
)
HEAD_START = 10.0  # [s] to read the warning


def parameter(name: str):
    """A private parameter of this suite."""
    return rospy.get_param(f"~{name}")


class Arm(unittest.TestCase):
    """Kinova's driver."""

    @classmethod
    def setUpClass(cls) -> None:
        announce()
        cls.arm = DriverClient(parameter("robot"))
        cls.arm.wait_until_there()
        cls.home = cls.arm.rest()

    def setUp(self) -> None:
        self.start = self.arm.halt()

    def elsewhere(self, angle: float = ANGLE) -> np.ndarray:
        """The start with joint_7 turned by an angle, towards where it was at first."""
        target = self.start.copy()
        off = wrapped(self.start - self.home)[6]
        target[6] += -angle if off > 0.0 else angle
        return target

    def test_feedback_names_the_arms_joints_in_order_and_comes_all_the_time(self) -> None:
        seen = list(self.arm.seen)[-40:]
        for _, message in seen:
            self.assertEqual(list(message.name), NAMES)
            for values in (message.position, message.velocity, message.effort):
                self.assertEqual(len(values), len(NAMES))
                self.assertTrue(np.isfinite(values).all())
            self.assertLessEqual(np.abs(message.position).max(), np.pi + 1e-6)
        apart = np.diff([message.header.stamp.to_sec() for _, message in seen])
        self.assertGreater(apart.min(), 0.0)
        self.assertTrue(0.005 < np.median(apart) < 0.1, f"{np.median(apart)} s apart")

    def test_joint_states_hold_the_same_joints(self) -> None:
        message = rospy.wait_for_message(f"{self.arm.name}/joint_states", JointState, 30.0)
        positions = dict(zip(message.name, message.position, strict=True))
        off = wrapped(np.array([positions[name] for name in NAMES]) - self.arm.q)
        self.assertLess(np.abs(off).max(), MOVED)

    def test_joints_by_other_names_or_in_another_order_are_rejected(self) -> None:
        """On a robot only goals that would move next to nothing where a driver took them."""
        orders = [[f"another_{name}" for name in NAMES], NAMES[:6]]
        if parameter("simulate"):
            orders += [NAMES[::-1], [*NAMES[:5], "joint_7", "joint_6"]]
        self.reject(*orders)

    def reject(self, *orders) -> None:
        """Goals for joints in these orders are rejected, and none of them moves anything."""
        first = time.monotonic()
        for names in orders:
            start, end = self.start[: len(names)], self.elsewhere()[: len(names)]
            handle, _ = self.arm.send([(start, 0.0), (end, 1.0)], names)
            self.assertEqual(self.arm.finish(handle)[0], GoalStatus.REJECTED)
        time.sleep(DELAY)
        self.assertIsNone(self.arm.first_motion(first, self.start))

    def test_a_goal_moves_the_arm_to_its_end_but_not_before_a_second(self) -> None:
        target = self.elsewhere()
        handle, sent = self.arm.send([(self.start, 0.0), (target, 1.0)])
        status, result = self.arm.finish(handle)
        self.assertEqual((status, result.error_code), (GoalStatus.SUCCEEDED, 0))
        there = self.arm.rest()
        self.assertLess(np.abs(wrapped(there - target)).max(), 0.005)
        delay = self.arm.first_motion(sent, self.start)
        self.assertGreater(delay, LEAST_DELAY)
        print(f"from the goal to its motion: {delay:.2f} s")

    def test_stop_ends_a_motion_for_good(self) -> None:
        handle, sent = self.arm.send([(self.start, 0.0), (self.elsewhere(2 * ANGLE), 6.0)])
        wait_until(lambda: self.arm.first_motion(sent, self.start), "no motion")
        self.arm.say("stop")
        there = self.arm.rest()
        self.assertLess(abs(wrapped(there - self.start)[6]), 1.5 * ANGLE)
        time.sleep(2.0)
        self.assertLess(np.abs(wrapped(self.arm.q - there)).max(), STILL)
        self.assertNotEqual(handle.get_goal_status(), GoalStatus.SUCCEEDED)

    def test_stop_before_the_motion_prevents_it(self) -> None:
        _, sent = self.arm.send([(self.start, 0.0), (self.elsewhere(), 1.0)])
        time.sleep(0.4)
        self.arm.say("stop")
        time.sleep(DELAY)
        self.assertIsNone(self.arm.first_motion(sent, self.start))

    def test_a_cancel_in_motion_stops(self) -> None:
        handle, sent = self.arm.send([(self.start, 0.0), (self.elsewhere(2 * ANGLE), 6.0)])
        wait_until(lambda: self.arm.first_motion(sent, self.start), "no motion")
        handle.cancel()
        there = self.arm.rest()
        self.assertLess(abs(wrapped(there - self.start)[6]), 1.5 * ANGLE)

    def test_a_velocity_goes_on_until_stop(self) -> None:
        sent = time.monotonic()
        self.arm.turn({6: np.sign(self.elsewhere()[6] - self.start[6]) * SPEED})
        try:
            wait_until(lambda: self.arm.first_motion(sent, self.start), "no motion")
            before = self.arm.q  # nothing is sent from here on
            wait_until(lambda: abs(wrapped(self.arm.q - before)[6]) > ON, "it went no further")
        finally:
            self.arm.say("stop")
        there = self.arm.rest()
        self.assertLess(np.abs(wrapped(there - self.start))[:6].max(), STILL)

    def test_velocities_of_zero_end_the_motion(self) -> None:
        sent = time.monotonic()
        self.arm.turn({6: np.sign(self.elsewhere()[6] - self.start[6]) * SPEED})
        try:
            wait_until(lambda: self.arm.first_motion(sent, self.start), "no motion")
            self.arm.turn(dict.fromkeys(range(7), 0.0))
            self.arm.rest()
        finally:
            self.arm.say("stop")


class Tool(unittest.TestCase):
    """OpenRST's node, only where it is simulated: homing moves its joints over all their range."""

    @classmethod
    def setUpClass(cls) -> None:
        if not parameter("simulate"):
            raise unittest.SkipTest("homing moves the tool over all its range")
        name = parameter("tool")
        cls.states, cls.joints = [], []
        cls.subscribers = [
            rospy.Subscriber(f"{name}/openrst_state", Int32MultiArray, cls.states.append),
            rospy.Subscriber(f"{name}/joint_states", JointState, cls.joints.append),
        ]
        command = f"{name}/effort_controller/command"
        cls.command = rospy.Publisher(command, Float64MultiArray, queue_size=1)
        rospy.wait_for_service(f"{name}/openrst_request", PATIENCE)
        cls.ask = rospy.ServiceProxy(f"{name}/openrst_request", openrst_request)
        wait_until(lambda: cls.states and cls.command.get_num_connections(), "no tool")

    def is_at(self, *joints: float) -> bool:
        return bool(np.abs(np.subtract(self.joints[-1].position, joints)).max() < 1e-3)

    def test_it_homes_and_then_goes_where_it_is_sent_or_against_its_stop(self) -> None:
        self.assertEqual(list(self.states[-1].data), [0])
        self.assertEqual(self.joints, [])
        self.assertTrue(self.ask("connect").succeeded)
        self.assertTrue(self.ask("calibrate").succeeded)
        wait_until(lambda: list(self.states[-1].data) == [2], "not READY after homing")
        self.assertTrue(self.ask("pos_control_on").succeeded)
        wait_until(lambda: list(self.states[-1].data) == [3], "not in position control")
        wait_until(lambda: self.joints, "no joint states though it is ready")
        names = ["joint_f0_pitch", "joint_f1_finger_left", "joint_f2_finger_right"]
        self.assertEqual(list(self.joints[-1].name), names)
        self.command.publish(Float64MultiArray(data=[0.2, 0.1, 0.3]))
        wait_until(lambda: self.is_at(0.2, 0.1, 0.3), "it did not go where it was sent")
        self.command.publish(Float64MultiArray(data=[0.2, 3.0, 0.3]))
        wait_until(lambda: self.joints[-1].position[1] > 1.5, "it is clamped")
        self.command.publish(Float64MultiArray(data=[0.0, 0.0, 0.0]))
        wait_until(lambda: self.is_at(0.0, 0.0, 0.0), "it did not come back")


def announce() -> None:
    """Say what will be done; on a real arm wait, so that a reader can stop it.

    Raises:
        AssertionError: Nobody said that there is an emergency stop.
    """
    simulated = parameter("simulate")
    if not simulated and not parameter("i_have_an_emergency_stop"):
        raise AssertionError(NO_EMERGENCY_STOP)
    rest = "It is simulated." if simulated else ON_A_ROBOT.format(wait=HEAD_START)
    words = WARNING.format(robot=parameter("robot"), angle=np.degrees(2 * ANGLE), rest=rest)
    rospy.logwarn(words)
    if not simulated:
        time.sleep(HEAD_START)


def suite() -> unittest.TestSuite:
    """The arm first, then the tool."""
    load = unittest.TestLoader().loadTestsFromTestCase
    return unittest.TestSuite([load(Arm), load(Tool)])


if __name__ == "__main__":
    run_tests("driver_contract.suite", "driver_contract")
