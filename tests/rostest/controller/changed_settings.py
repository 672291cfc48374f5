#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Somebody changes a setting on the parameter server while the system runs."""

import rospy

from rst_control.msg import ReasonCode
from tests.support.robot_client import RobotTest, run_tests

LIMIT = "controller/controller/tension/limit"
KEPT = "robot/launched"
ONCE, TWICE = 3.0, 5.0  # [s] in which the controller reads the server so often, every 2 s


class ChangedSettings(RobotTest):
    """The tests run in the order of their names and build on one robot."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.launched, cls.kept = rospy.get_param(LIMIT), rospy.get_param(KEPT)
        cls.robot.start_fresh()

    @classmethod
    def tearDownClass(cls):
        rospy.set_param(LIMIT, cls.launched)
        rospy.delete_param("robot/pause")
        rospy.set_param(KEPT, cls.kept)
        super().tearDownClass()

    def test_1_a_changed_setting_latches_and_is_named(self):
        rospy.set_param(LIMIT, 24.0)
        self.robot.wait_for_state("halted")
        self.assertEqual(self.robot.state.halt_reason_code, ReasonCode.SETTINGS_CHANGED)
        self.assertIn(f"tension/limit is 24.0, at the launch {self.launched}", self.reason())

    def test_2_who_has_read_it_may_go_on_with_those_of_the_launch(self):
        self.robot.activate()
        rospy.sleep(ONCE)
        self.assertEqual(self.robot.state.state, "active")

    def test_3_another_difference_latches_again(self):
        rospy.set_param("robot/pause", 1.0)  # no section of the launch
        rospy.set_param(LIMIT, 30.0)
        self.robot.wait_for_state("halted")
        self.assertIn("tension/limit is 30.0", self.reason())
        self.assertNotIn("pause", self.reason())

    def test_4_a_node_that_is_launched_again_with_the_same_settings_stops_nothing(self):
        rospy.delete_param(KEPT)  # as a launch does, until the node has started
        self.robot.activate()
        rospy.sleep(TWICE)
        self.assertEqual(self.robot.state.state, "active")

    def reason(self):
        return self.robot.state.halt_reason


if __name__ == "__main__":
    run_tests(ChangedSettings, "changed_settings")
