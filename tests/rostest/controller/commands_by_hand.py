#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Each command, given by the service alone, and what the simulated robot does about it.

Nobody records, which the setting `ignore` allows: everything works, and the log says it once.
"""

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from rosgraph_msgs.msg import Log

from rst_control.srv import Command, CommandRequest
from tests.support.robot_client import RobotTest, run_tests


class CommandsByHand(RobotTest):
    """The tests run in the order of their names and build on one robot."""

    @classmethod
    def setUpClass(cls):
        cls.said, cls.statuses = [], {}
        rospy.Subscriber("/rosout_agg", Log, lambda m: cls.said.append(m.msg))
        rospy.Subscriber("/diagnostics", DiagnosticArray, cls.take_diagnostics)
        super().setUpClass()

    @classmethod
    def take_diagnostics(cls, array):
        cls.statuses.update({status.name: status.message for status in array.status})

    def test_1_nothing_moves_before_hey_robot(self):
        for command in ("tense", "release", "pull more", "pull less", "terminate"):
            self.assertIn("hey robot", self.robot.refused(command))
        self.assertEqual(self.robot.state.state, "standby")

    def test_2_what_is_no_command_is_refused_with_the_list_of_commands(self):
        for words in ("dance", "", "tense now", "ten\x00se", "停", "pull", "x" * 100_000):
            reason = self.robot.refused(words)
            for command in (
                "hey robot",
                "tense",
                "release",
                "pull more",
                "pull less",
                "stop",
                "terminate",
            ):
                self.assertIn(command, reason)
            self.assertLess(len(reason), 400)

    def test_2_bytes_that_are_no_text_are_refused(self):
        class RawRequest(CommandRequest):
            def serialize(self, buff):
                buff.write(b"\x03\x00\x00\x00\xff\xfe\x80")

        reply = rospy.ServiceProxy("rst_control/command", Command).call(RawRequest())
        self.assertFalse(reply.accepted)

    def test_3_hey_robot_activates(self):
        self.robot.activate()
        self.robot.wait_for_state("active")
        self.assertIn("nothing", self.robot.refused("pull more"))

    def test_4_tense_grasps_and_pulls_to_a_tension(self):
        self.robot.say_and_finish("tense", limit=40)
        target = self.robot.state.tension_target
        self.assertTrue(self.robot.state.tissue_held)
        self.assertGreater(target, 0.1)
        self.assertAlmostEqual(self.robot.tension, target, delta=0.1 * target)
        self.assertLess(self.robot.max_rcm_error(), 50e-6)

    def test_5_pull_more_raises_and_pull_less_lowers_the_tension(self):
        before = self.robot.tension
        self.robot.say_and_finish("pull more")
        more = self.robot.tension
        self.assertGreater(more, before)
        self.robot.say_and_finish("pull less")
        self.assertLess(self.robot.tension, more)

    def test_6_pull_more_may_be_said_again_while_it_moves(self):
        target = self.robot.state.tension_target
        self.robot.say("pull more")
        self.robot.say_and_finish("pull more")
        self.assertGreater(self.robot.state.tension_target, target + 0.3)
        self.robot.say_and_finish("pull less")

    def test_7_release_lets_the_tension_fall_to_zero(self):
        self.robot.say_and_finish("release")
        self.assertFalse(self.robot.state.tissue_held)
        self.assertLess(self.robot.tension, 0.02)
        self.assertIn("nothing", self.robot.refused("pull less"))

    def test_8_terminate_stands_by_and_hears_only_hey_robot_and_stop(self):
        self.robot.say("terminate")
        self.robot.wait_for_state("standby")
        self.assertFalse(self.robot.state.assistance_enabled)
        self.assertIn("hey robot", self.robot.refused("tense"))
        self.robot.say("stop")
        self.robot.wait_for_state("halted")

    def test_9_every_answer_is_in_the_event_log(self):
        answers = {"accepted", "refused", "motion_started", "motion_finished"}
        wanted = answers | {"stop_received", "halted"}
        self.robot.wait(lambda: wanted <= {event.kind for event in self.robot.events})

    def test_9_after_all_of_them_the_log_has_said_once_that_nothing_is_recorded(self):
        words = "not recorded: no recorder was ever heard"
        self.robot.wait(lambda: self.statuses.get("rst_control: recording") == words)
        reported = [line for line in self.said if "not recorded" in line]
        self.assertLessEqual(len(reported), 1)  # none if it was said before this test listened
        self.assertTrue(all(line == f"{words}; ignored, as it was set" for line in reported))


if __name__ == "__main__":
    run_tests(CommandsByHand, "commands_by_hand")
