#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The tool goes in and out by hand, by the service alone, and never because a voice said so."""

import subprocess
import sys
import unittest

import rospy
import rostest

from tests.support.robot_client import RobotClient

VOICE = """
import sys, rospy
from rst_control.srv import Command
rospy.init_node("plays_the_voice")
rospy.wait_for_service("rst_control/command", 20.0)
reply = rospy.ServiceProxy("rst_control/command", Command)(sys.argv[1])
print("accepted" if reply.accepted else "refused", reply.message)
"""


class Insertion(unittest.TestCase):
    """The tests run in the order of their names and build on one robot."""

    @classmethod
    def setUpClass(cls):
        cls.robot = RobotClient()

    def heard(self, command):
        """What the controller answers the voice node."""
        spoken = [sys.executable, "-c", VOICE, command]
        return subprocess.run(spoken, capture_output=True, text=True, timeout=60, check=True).stdout

    def test_1_the_controller_comes_up_with_the_tool_outside(self):
        self.robot.wait(lambda: self.robot.state.insertion < -0.01)
        self.assertIn("hey robot", self.robot.refused("insert"))
        self.robot.activate()
        reason = self.robot.refused("tense")
        self.assertIn("tool not inserted", reason)
        self.assertIn("already outside", self.robot.refused("withdraw"))

    def test_2_the_voice_node_is_refused(self):
        for command in ("insert", "withdraw"):
            answer = self.heard(command)
            self.assertIn("refused", answer)
            self.assertIn("by hand, never by voice", answer)
        self.assertLess(self.robot.drift(0.3), 1e-4)

    def test_3_insert_takes_the_tool_to_its_working_pose(self):
        self.robot.say_and_finish("insert", limit=90)
        self.assertAlmostEqual(self.robot.state.insertion, 0.1205, delta=0.002)
        self.assertLess(self.robot.state.rcm_error, 20e-6)
        inside = [s.rcm_error for s in self.robot.states if s.insertion > 0.0]
        self.assertLess(max(inside), 50e-6)
        phases = {s.phase for s in self.robot.states}
        self.assertLessEqual({"approach", "insert", "hold"}, phases)
        self.assertIn("already inserted", self.robot.refused("insert"))

    def test_4_a_stop_half_way_out_latches_and_hey_robot_lets_it_go_on(self):
        self.robot.say("withdraw")
        self.robot.wait(lambda: self.robot.state.insertion < 0.09, limit=60)
        self.robot.say("stop")
        self.robot.wait_for_state("halted")
        self.robot.wait(lambda: self.robot.speed() < 1e-3)  # the robot plays set-points late
        self.assertLess(self.robot.drift(0.3), 1e-3)
        self.assertGreater(self.robot.state.insertion, 0.0)
        self.assertIn("halted", self.robot.refused("withdraw"))
        self.robot.activate()
        self.robot.say_and_finish("withdraw", limit=90)
        self.assertAlmostEqual(self.robot.state.insertion, -0.030, delta=0.002)
        self.assertIn("withdraw", {s.phase for s in self.robot.states})


if __name__ == "__main__":
    rospy.init_node("insertion")
    rostest.rosrun("rst_control", "insertion", Insertion, sys.argv)
