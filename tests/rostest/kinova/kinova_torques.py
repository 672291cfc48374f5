#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Pulls through the bridge by a tension that is estimated from the arm's own noisy torques."""

import unittest

import rospy
from geometry_msgs.msg import WrenchStamped
from std_msgs.msg import Bool, String

from tests.support.robot_client import START_LIMIT, Halted, RobotClient, run_tests

ROUGH = 0.6  # [N] by which a pull led by noisy torques may miss; what they are worth says the bench
CLOSE = 0.5  # [N] by which the estimate may be off, at rest
TRIES = 3  # to grasp: on a machine that stalls few torques come; the robot holds, or pulls badly
PULLS = 40  # until one is refused, at most; two do where the estimate is good
MOST = 2.4  # [N] at which the controller gives up


class KinovaTorques(unittest.TestCase):
    """In the order of their names, on one robot."""

    @classmethod
    def setUpClass(cls):
        cls.true, cls.most, cls.invalid, cls.gripped = 0.0, 0.0, None, False
        rospy.Subscriber("simulation/tension", WrenchStamped, cls.on_true)
        rospy.Subscriber("simulation/gripped", Bool, lambda m: setattr(cls, "gripped", m.data))
        rospy.Subscriber("robot/tension_invalid_reason", String, cls.on_invalid)
        cls.robot = RobotClient()

    @classmethod
    def on_true(cls, message):
        force = message.wrench.force
        cls.true = (force.x**2 + force.y**2 + force.z**2) ** 0.5
        cls.most = max(cls.most, cls.true)

    @classmethod
    def on_invalid(cls, message):
        cls.invalid = message.data

    def grasp(self):
        """Say "tense", and after a halt or a poor pull begin anew, as its user would."""
        outcomes = []
        for _ in range(TRIES):
            try:
                self.robot.say_and_finish("tense", limit=60.0)
            except Halted as halt:
                outcomes.append(str(halt))
                self.robot.start_fresh()
                continue
            if abs(self.true - 1.0) < ROUGH:
                return
            outcomes.append(f"{self.true:.2f} N")
            self.release()
        self.fail(f"pulled badly, or halted, each time: {outcomes}")

    def release(self):
        """Say "release", and after a halt begin anew, which releases what is held."""
        try:
            self.robot.say_and_finish("release", limit=60.0)
        except Halted:
            self.robot.start_fresh()

    def assert_estimated(self):
        """The estimate settles near the true tension."""
        self.robot.wait(lambda: abs(self.robot.tension - self.true) < CLOSE, 20.0)

    def say_until_refused(self, command):
        """Pull until it is refused, and begin anew after a halt; gives the refusal."""
        for _ in range(PULLS):
            count, halts = self.robot.finished(command), len(self.robot.halts())
            reply = self.robot.command(command)
            if not reply.accepted:
                return reply.message
            try:
                self.robot.finish(command, count, halts, limit=60.0)
            except Halted:
                self.robot.start_fresh()
                self.grasp()
            self.assert_estimated()
        return ""

    def test_1_before_the_jaws_were_open_at_rest_it_is_not_trusted(self):
        self.robot.wait(lambda: self.invalid and self.invalid.startswith("no tare"), START_LIMIT)
        self.robot.home_tool()
        self.robot.activate()

    def test_2_tense_pulls_to_about_the_tension_asked_for(self):
        self.grasp()
        self.assertTrue(self.gripped)
        self.assertEqual(self.invalid, "")
        self.assertAlmostEqual(self.true, 1.0, delta=ROUGH)
        self.assert_estimated()

    def test_3_more_than_the_maximum_is_refused(self):
        before = self.true
        self.assertIn("allowed 0.10 to 1.50 N", self.say_until_refused("pull more"))
        self.assertGreater(self.true, before)

    def test_4_pull_less_pulls_less(self):
        before = self.true
        self.say_until_refused("pull less")  # one step is less than what the torques may be off by
        self.assertLess(self.true, before)

    def test_5_release_lets_go_and_nothing_was_ever_torn(self):
        self.release()
        self.assertFalse(self.gripped)
        self.assertEqual(self.true, 0.0)
        self.assert_estimated()
        self.assertLess(self.most, MOST)
        self.assertLess(self.robot.max_rcm_error(), 1e-3)


if __name__ == "__main__":
    run_tests(KinovaTorques, "kinova_torques")
