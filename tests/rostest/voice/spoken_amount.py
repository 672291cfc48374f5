#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""From the sound of an amount to a robot that goes for it, and near misses that move nothing."""

import sys
import unittest

import rospy
import rostest

from tests.support.robot_client import RobotClient
from tests.support.spoken_topic import Microphone
from voice_assist.msg import Utterance

SAID, SENT, TARGET = "tension one point five", "tense 1.5 N", 1.5  # [N]
NEAR = ("tension one point nine", "the tension is one point five")
READY, HEARD = 120.0, 15.0  # [s] allowed for the voice node to listen, and for a decision


class SpokenAmount(unittest.TestCase):
    """Amounts are on in this launch."""

    @classmethod
    def setUpClass(cls):
        cls.robot, cls.microphone, cls.heard = RobotClient(), Microphone(), []
        rospy.Subscriber("voice_assist/utterance", Utterance, cls.heard.append)
        cls.robot.start_fresh()
        end = rospy.get_time() + READY
        while not cls.heard and rospy.get_time() < end:
            cls.microphone.say("good morning")
            rospy.sleep(2.0)
        assert cls.heard, "the voice node hears nothing"

    @classmethod
    def tearDownClass(cls):
        cls.microphone.timer.shutdown()
        cls.robot.leave()

    def setUp(self):
        self.robot.start_fresh()
        self.heard.clear()

    def say(self, words):
        """Say it; returns what was decided."""
        self.microphone.say(words)
        self.robot.wait(lambda: self.heard, HEARD)
        return self.heard[-1]

    def test_an_amount_moves_the_robot_and_is_its_target(self):
        decided = self.say(SAID)
        self.assertEqual(decided.command, SAID, decided)
        self.robot.wait_for_state("moving")
        self.assertEqual(self.robot.state.command, SENT)
        self.robot.wait(lambda: self.robot.state.tension_target == TARGET)
        started = [e.command for e in self.robot.events if e.kind == "motion_started"]
        self.assertEqual(started[-1], SENT)
        self.robot.stop_topic.publish()
        self.robot.wait_for_state("halted")

    def test_near_misses_move_nothing(self):
        events = len(self.robot.events)
        for words in NEAR:
            self.heard.clear()
            decided = self.say(words)
            self.assertEqual(decided.command, "", decided)
            rospy.sleep(0.5)
        self.assertEqual(self.robot.state.state, "active")
        self.assertEqual([e.kind for e in self.robot.events[events:]], [])


if __name__ == "__main__":
    rospy.init_node("spoken_amount")
    rostest.rosrun("rst_control", "spoken_amount", SpokenAmount, sys.argv)
