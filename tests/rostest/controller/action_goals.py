#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The action server: every kind of ending, and feedback on the way."""

import actionlib
import rospy
from actionlib.action_client import CommState
from actionlib_msgs.msg import GoalStatus

from rst_control.msg import AssistAction, AssistGoal
from tests.support.robot_client import RobotTest, run_tests


class ActionGoals(RobotTest):
    """Goals go through the same verification and motion as commands in words."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.client = actionlib.SimpleActionClient("rst_control/execute", AssistAction)
        assert cls.client.wait_for_server(rospy.Duration(30))

    def send(self, **goal):
        self.feedback = []
        self.client.send_goal(AssistGoal(**goal), feedback_cb=self.feedback.append)

    def result(self):
        """The result; docs/reference/interfaces.md says why not by `wait_for_result`."""
        self.robot.wait(lambda: self.client.gh.get_comm_state() == CommState.DONE, 40)
        return self.client.get_result()

    def test_1_a_goal_before_hey_robot_is_refused_with_the_reason(self):
        self.send(command="tense")
        self.assertEqual(self.result().outcome, "refused")
        self.assertEqual(self.client.get_state(), GoalStatus.REJECTED)
        self.assertIn("hey robot", self.client.get_goal_status_text())

    def test_2_tense_to_a_tension_of_the_goal(self):
        self.robot.activate()
        self.send(command="tense", tension=0.6)
        result = self.result()
        self.assertEqual(result.outcome, "succeeded", result.reason)
        self.assertAlmostEqual(result.tension, 0.6, delta=0.06)
        self.assertLess(result.max_rcm_error, 50e-6)
        self.assertGreater(result.max_rcm_error, 0.0)
        self.assertLessEqual({"reach", "close", "pull"}, {f.phase for f in self.feedback})
        self.assertTrue(all(0.0 <= f.progress <= 1.0 for f in self.feedback))

    def test_3_a_step_by_a_distance_of_the_goal(self):
        before = self.robot.state.path_position
        self.send(command="pull more", distance=0.001)
        self.assertEqual(self.result().outcome, "succeeded")
        self.assertGreater(self.robot.tension, 0.6)
        self.robot.wait(lambda: self.robot.state.path_position != before)

    def test_4_what_cannot_be_done_is_refused(self):
        for goal in (
            {"command": "dance"},
            {"command": "tense"},
            {"command": "pull more", "distance": 10.0},
            {"command": "pull more", "tension": float("nan")},
            {"command": "pull more", "tension": -1.0},
        ):
            self.send(**goal)
            self.assertEqual(self.result().outcome, "refused", goal)

    def test_5_release_succeeds(self):
        self.send(command="release")
        self.assertEqual(self.result().outcome, "succeeded")
        self.assertLess(self.result().tension, 0.02)


if __name__ == "__main__":
    run_tests(ActionGoals, "action_goals")
