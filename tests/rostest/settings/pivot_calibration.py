#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Pivot calibration on the running system: the shaft is tilted in a trocar that is not set."""

import unittest
from dataclasses import replace

import numpy as np
import rospy
from geometry_msgs.msg import PointStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Empty, String
from std_srvs.srv import Trigger

from rst_control.config import load_motion_config
from rst_control.kinematics.configuration import Configuration, planning_joints, robot_joints
from rst_control.kinematics.robot_model import load_robot
from rst_control.registration.trocar_context import TrocarContext
from rst_control.srv import FitTrocar
from rst_control.types import JOINTS
from tests.support.robot_client import RobotClient, run_tests

TRUE = np.array([0.409, -0.026, 0.417])  # [m] where the trocar truly is; scene.yaml says elsewhere
TILTS = ((0.0, 0.0), (0.025, 0.0), (-0.02, 0.0), (0.0, 0.025), (0.0, -0.025), (0.02, 0.02))  # [m]
EXACT = 10e-6  # [m] that the fitted trocar may be off the true one
PERIOD, DURATION, AHEAD = 0.002, 1.6, 0.5  # [s] of set-points, of a move, before it begins
STEP = 1e-4  # share of the way for differences
ATTEMPTS = 4  # at one move


class PivotCalibration(unittest.TestCase):
    """The tests run in the order of their names and build on one robot."""

    @classmethod
    def setUpClass(cls):
        config = load_motion_config()
        scene = replace(config.scene, trocar=tuple(TRUE))
        cls.planner = TrocarContext(replace(config, scene=scene), load_robot()).planner
        cls.robot = RobotClient()
        cls.servo = rospy.Publisher("robot/servo_jp", JointState, queue_size=2000)
        cls.clear = rospy.Publisher("robot/clear_fault", Empty, queue_size=1)
        cls.faults = []
        cls.subscriber = rospy.Subscriber("robot/fault", String, cls.faults.append)
        cls.robot.wait(lambda: cls.servo.get_num_connections() and cls.clear.get_num_connections())
        cls.robot.wait(lambda: cls.faults)
        for name in ("record_shaft", "forget_shafts", "fit_trocar"):
            rospy.wait_for_service(f"rst_control/{name}", 60.0)
        cls.record = rospy.ServiceProxy("rst_control/record_shaft", Trigger)
        cls.forget = rospy.ServiceProxy("rst_control/forget_shafts", Trigger)
        cls.fit = rospy.ServiceProxy("rst_control/fit_trocar", FitTrocar)

    def joints(self):
        return planning_joints(np.array(self.robot.joints.position))[0]

    def go(self, plan, on_the_way=lambda: None):
        """Guide the robot along a plan to rest; again where a loaded machine held up the stream.

        `plan` gives, for where the robot is, a function of the share of the way to joints (9,).
        """
        for _ in range(ATTEMPTS):
            point = plan()
            end = robot_joints(point(1.0), 0.0)
            self.guide(point)
            on_the_way()
            self.robot.wait(lambda end=end: self.fault or self.rests_at(end))
            if not self.fault:
                return
            self.clear.publish(Empty())
            self.robot.wait(lambda: not self.fault)
        raise AssertionError("the robot could not be guided")

    @property
    def fault(self):
        return self.faults[-1].data

    def rests_at(self, joints):
        away = np.abs(np.subtract(self.robot.joints.position, joints)).max()
        return away < 1e-5 and self.robot.speed() < 1e-4

    def guide(self, point):
        """Send a whole move in advance."""
        messages = []
        for t in np.linspace(0.0, 1.0, round(DURATION / PERIOD) + 1):
            share = t**3 * (10.0 - 15.0 * t + 6.0 * t**2)
            rate = 30.0 * t**2 * (1.0 - t) ** 2 / DURATION
            low, high = max(share - STEP, 0.0), min(share + STEP, 1.0)
            slope = (point(high) - point(low)) / (high - low)
            message = JointState(name=JOINTS, position=robot_joints(point(share), 0.0).tolist())
            message.velocity = robot_joints(slope * rate, 0.0).tolist()
            messages.append(message)
        start = rospy.Time.now() + rospy.Duration(AHEAD)
        for n, message in enumerate(messages):
            message.header.stamp = start + rospy.Duration(n * PERIOD)
            self.servo.publish(message)

    def into_the_true_trocar(self):
        start = self.joints()
        goal = self.planner.project(start)
        return lambda share: start + share * (goal - start)

    def tilt(self, x, y):
        q = self.joints()
        goal = Configuration(load_robot(), q).T_base_tip
        goal[:3, 3] = self.planner.centre + np.array([x, y, 0.0])
        path = self.planner.leg(q, goal)
        return lambda share: path.evaluate(share * path.length).q

    def record_in_motion(self):
        self.robot.wait(lambda: self.fault or self.robot.speed() > 0.02)
        reply = self.record()
        if not self.fault:
            self.assertFalse(reply.success)
            self.assertIn("not at rest", reply.message)

    def test_1_without_poses_nothing_is_fitted(self):
        self.assertIn("0 shaft poses recorded, allowed 5", self.fit(False).message)
        self.assertFalse(self.fit(True).accepted)

    def test_2_one_pose_many_times_is_not_enough(self):
        for n in range(6):
            self.assertIn(f"{n + 1} shaft poses recorded", self.record().message)
        reply = self.fit(False)
        self.assertFalse(reply.accepted)
        self.assertIn("tilt the shaft further", reply.message)
        self.assertIn("6 shaft poses forgotten", self.forget().message)

    def test_3_poses_at_rest_are_recorded_and_none_while_the_shaft_moves(self):
        self.go(self.into_the_true_trocar)
        for x, y in TILTS:
            self.go(lambda x=x, y=y: self.tilt(x, y), self.record_in_motion)
            self.assertTrue(self.record().success)

    def test_4_the_fit_is_the_true_trocar_and_sets_nothing_by_itself(self):
        reply = self.fit(False)
        self.assertTrue(reply.accepted, reply.message)
        found = np.array([reply.position.x, reply.position.y, reply.position.z])
        print(f"fitted trocar {np.linalg.norm(found - TRUE) * 1e6:.3f} um off; {reply.message}")
        self.assertLess(np.linalg.norm(found - TRUE), EXACT)
        self.assertEqual((reply.poses, list(reply.outliers)), (len(TILTS), []))
        self.assertLess(reply.max_residual, EXACT)
        self.assertGreater(reply.angular_spread, 0.05)
        self.assertGreater(self.robot.state.rcm_error, 1e-3)

    def test_5_applied_it_is_active(self):
        reply = self.fit(True)
        self.assertTrue(reply.accepted, reply.message)
        p = rospy.wait_for_message("rst_control/trocar", PointStamped, 30.0).point
        self.assertLess(np.linalg.norm(np.array([p.x, p.y, p.z]) - TRUE), EXACT)
        self.robot.wait(lambda: self.robot.state.rcm_error < EXACT)
        self.assertIn("0 shaft poses recorded", self.fit(False).message)


if __name__ == "__main__":
    run_tests(PivotCalibration, "pivot_calibration")
