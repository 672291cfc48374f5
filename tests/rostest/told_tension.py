#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Pulls by a tension that is told from joint torques, beside the true one."""

import sys
import unittest

import rospy
import rostest
from geometry_msgs.msg import WrenchStamped
from robot_client import RobotClient
from std_msgs.msg import String

ROUGH = 0.4  # [N] by which a pull led by torques may miss
CLOSE = 0.15  # [N] by which the estimate may be off with ideal motors, at rest


class TensionFromTorques(unittest.TestCase):
    """The whole way: joint states, estimate, controller."""

    @classmethod
    def setUpClass(cls):
        cls.true, cls.distrust = 0.0, None
        cls._subscribers = [
            rospy.Subscriber("robot/true_tension", WrenchStamped, cls._on_true),
            rospy.Subscriber("robot/tension_distrust", String, cls._on_distrust),
        ]
        cls.robot = RobotClient()
        cls.robot.wait(lambda: cls.distrust is not None)

    @classmethod
    def _on_true(cls, message):
        force = message.wrench.force
        cls.true = (force.x**2 + force.y**2 + force.z**2) ** 0.5

    @classmethod
    def _on_distrust(cls, message):
        cls.distrust = message.data

    def assert_told(self):
        """The estimate settles on the true tension."""
        self.robot.wait(lambda: abs(self.robot.tension - self.true) < CLOSE, 20.0)

    def test_1_before_the_jaws_were_open_at_rest_it_is_not_trusted(self):
        self.robot.wait(lambda: self.distrust.startswith("no tare"))

    def test_2_tense_pulls_to_about_the_tension_asked_for(self):
        self.robot.activate()
        self.robot.say_and_finish("tense", 60.0)
        self.assertEqual(self.distrust, "")
        self.assertAlmostEqual(self.true, 1.0, delta=ROUGH)
        self.assert_told()

    def test_3_pull_more_pulls_more_and_less_pulls_less(self):
        before = self.true
        self.robot.say_and_finish("pull more", 60.0)
        more = self.true
        self.assertGreater(more, before)  # by how much says `make bench ONLY=torque_tension`
        self.assert_told()
        self.robot.say_and_finish("pull less", 60.0)
        self.assertLess(self.true, more)

    def test_4_more_than_the_maximum_is_refused(self):
        for _ in range(6):
            done = self.robot.finished("pull more")
            reply = self.robot.command("pull more")
            if not reply.accepted:
                break
            self.robot.wait(lambda done=done: self.robot.finished("pull more") > done, 60.0)
            self.assert_told()
        self.assertIn("allowed 0.10 to 1.50 N", reply.message)
        self.assertLess(self.true, 2.4)

    def test_5_after_release_nothing_is_felt(self):
        self.robot.say_and_finish("release", 60.0)
        self.assertEqual(self.true, 0.0)
        self.robot.wait(lambda: self.robot.tension < CLOSE and self.distrust == "")
        self.assertLess(self.robot.max_rcm_error(), 1e-3)


if __name__ == "__main__":
    rospy.init_node("told_tension")
    rostest.rosrun("rst_control", "told_tension", TensionFromTorques, sys.argv)
