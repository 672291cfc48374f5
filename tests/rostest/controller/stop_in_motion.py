#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Stop by service, by topic and by action cancel, in the middle of a motion."""

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from std_msgs.msg import Empty

from rst_control.msg import AssistAction, AssistGoal
from tests.support.robot_client import RobotTest, run_tests


class StopInMotion(RobotTest):
    """Each test sets the robot moving, stops it and checks that it stays stopped."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.client = actionlib.SimpleActionClient("rst_control/execute", AssistAction)
        assert cls.client.wait_for_server(rospy.Duration(30))

    def setUp(self):
        self.robot.start_fresh()
        self.robot.states.clear()
        self.carried_out = self.robot.finished("tense")

    def assert_halts(self):
        self.robot.wait_for_state("halted", limit=5)
        self.assertIn("stop", self.robot.state.halt_reason)
        self.robot.wait(lambda: self.robot.drift(0.1) < 1e-4, limit=5)
        self.assertLess(self.robot.max_rcm_error(), 50e-6)
        for command in ("tense", "release", "pull more"):
            self.assertIn("halted", self.robot.refused(command))
        self.assertLess(self.robot.drift(0.3), 1e-3)

    def test_stop_by_service(self):
        self.robot.say("tense")
        self.robot.wait_for_motion()
        self.robot.say("stop")
        self.assert_halts()
        self.assertEqual(self.robot.finished("tense"), self.carried_out)

    def test_stop_by_topic(self):
        self.robot.say("tense")
        self.robot.wait_for_motion()
        self.robot.stop_topic.publish(Empty())
        self.assert_halts()
        self.assertEqual(self.robot.finished("tense"), self.carried_out)

    def test_cancelled_action(self):
        self.client.send_goal(AssistGoal(command="tense"))
        self.robot.wait_for_motion()
        self.client.cancel_goal()
        self.assert_halts()
        self.assertTrue(self.client.wait_for_result(rospy.Duration(5)))
        self.assertEqual(self.client.get_state(), GoalStatus.PREEMPTED)
        self.assertEqual(self.client.get_result().outcome, "stopped")

    def test_stop_by_service_ends_the_action_with_its_reason(self):
        self.client.send_goal(AssistGoal(command="tense"))
        self.robot.wait_for_motion()
        self.robot.say("stop")
        self.assert_halts()
        self.assertTrue(self.client.wait_for_result(rospy.Duration(5)))
        self.assertEqual(self.client.get_result().outcome, "stopped")
        self.assertIn("stop", self.client.get_result().reason)

    def test_terminate_in_motion_brakes_and_stands_by(self):
        self.robot.say("tense")
        self.robot.wait_for_motion()
        self.robot.say("terminate")
        self.robot.wait_for_state("standby", limit=5)
        self.robot.wait(lambda: self.robot.speed() < 2e-3, limit=2)

    def test_grip_is_kept_when_stopped_while_pulling(self):
        self.robot.say("tense")
        self.robot.wait(lambda: self.robot.state.phase == "pull" and self.robot.tension > 0.1)
        self.robot.say("stop")
        self.assert_halts()
        self.assertTrue(self.robot.state.tissue_held)
        self.assertGreater(self.robot.tension, 0.05)


if __name__ == "__main__":
    run_tests(StopInMotion, "stop_in_motion")
