#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The voice node falls silent, the robot dies, the dead-man hangs, each in a motion.

This test bears the name of the voice node, for the controller knows spoken commands by it; it is
believed as a pedal, too.
"""

import unittest

import rospy
from std_msgs.msg import Bool, Time

from tests.support.robot_client import RobotClient, apart, kill, run_tests


class LostNodes(unittest.TestCase):
    """Every loss brakes, latches and is named; nothing goes on by itself."""

    @classmethod
    def setUpClass(cls):
        cls.robot = RobotClient()
        cls.heartbeat = rospy.Publisher("rst_control/heartbeat", Time, queue_size=1)
        cls.robot.wait(lambda: cls.heartbeat.get_num_connections() > 0)

    def tense(self):
        """Give the command, once the heartbeats have come."""
        self.robot.wait(lambda: self.robot.command("tense").accepted, every=0.1)

    def test_1_a_spoken_command_brakes_when_the_heartbeat_ends(self):
        self.robot.start_fresh()
        beat = rospy.Timer(rospy.Duration(0.05), lambda _: self.heartbeat.publish(Time()))
        self.tense()
        self.robot.wait_for_motion()
        beat.shutdown()
        self.robot.wait_for_state("faulted", limit=5)
        self.assertIn("voice node silent", self.robot.state.halt_reason)

    def test_2_without_heartbeat_nothing_spoken_moves(self):
        self.robot.activate()
        self.assertIn("voice node silent", self.robot.refused("tense"))
        self.assertEqual(self.robot.state.state, "active")
        self.robot.say("stop")
        self.robot.wait_for_state("halted")

    def test_3_a_dead_robot_is_named_and_waited_for(self):
        beat = rospy.Timer(rospy.Duration(0.05), lambda _: self.heartbeat.publish(Time()))
        self.addCleanup(beat.shutdown)
        self.robot.start_fresh()
        for command in ("insert", "withdraw"):
            self.assertIn("by hand, never by voice", self.robot.refused(command))
        self.tense()
        self.robot.wait_for_motion()
        kill("robot")
        self.robot.wait_for_state("faulted", limit=5)
        self.assertRegex(self.robot.state.halt_reason, "stale|not connected")
        self.assertIn("halted", self.robot.refused("tense"))
        self.robot.activate()  # `respawn` has started it again; nothing else was
        self.tense()
        self.robot.wait_for_motion()
        self.robot.say("stop")
        self.robot.wait_for_state("halted")

    def test_4_a_robot_that_is_started_anew_in_mid_pull_is_moved_by_nobody(self):
        beat = rospy.Timer(rospy.Duration(0.05), lambda _: self.heartbeat.publish(Time()))
        self.addCleanup(beat.shutdown)
        self.robot.start_fresh()
        self.tense()
        self.robot.wait(lambda: self.robot.state.phase == "pull" and self.robot.tension > 0.2)
        kill("robot")
        self.robot.wait_for_state("faulted", limit=5)
        self.robot.activate()  # `respawn` has started it again: at home, with nothing held
        begun = self.robot.measured()
        self.assertIn("grasped", self.robot.refused("pull more"))
        rospy.sleep(1.0)
        self.assertLess(apart(begun, self.robot.measured()), 1e-4)
        self.assertFalse(self.robot.state.tissue_held)
        self.assertEqual(self.robot.state.state, "active")

    def test_5_a_dead_man_that_falls_silent_brakes(self):
        dead_man = rospy.Publisher("rst_control/dead_man", Bool, queue_size=1)
        self.robot.wait(lambda: dead_man.get_num_connections() > 0)
        beat = rospy.Timer(rospy.Duration(0.05), lambda _: self.heartbeat.publish(Time()))
        self.addCleanup(beat.shutdown)
        self.robot.start_fresh()
        dead_man.publish(Bool(False))
        self.robot.wait(lambda: "dead-man" in self.robot.command("tense").message, every=0.1)
        held = rospy.Timer(rospy.Duration(0.05), lambda _: dead_man.publish(Bool(True)))
        self.tense()
        self.robot.wait_for_motion()
        held.shutdown()
        self.robot.wait_for_state("halted", limit=5)
        self.assertEqual(self.robot.state.halt_reason_code, "dead_man")


if __name__ == "__main__":
    run_tests(LostNodes, "voice_assist")
