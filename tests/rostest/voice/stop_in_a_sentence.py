#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""From sound to a robot that stops, or does not: the same sentences at rest and in motion."""

from contextlib import suppress

import rospy

from tests.rostest.voice.spoken_topic import SpokenTo
from tests.support.robot_client import run_tests
from voice_assist.msg import Mode

WITH_STOP, WITHOUT = "he said stop and went on", "he said pull more and went on"
MOTIONS = 3


class StopInASentence(SpokenTo):
    """More of them: test_stop_in_motion.py, and the bench."""

    @classmethod
    def setUpClass(cls):
        cls.modes = []
        rospy.Subscriber("voice_assist/mode", Mode, lambda m: cls.modes.append(m.mode))
        super().setUpClass()

    def commands(self):
        return [one.command for one in self.heard if one.command]

    def move(self):
        self.robot.say("tense")
        self.robot.wait_for_state("moving")

    def test_in_motion_a_stop_in_a_sentence_stops(self):
        """In one of three motions: how often it is heard is what `voice.overlap` measures."""
        for _ in range(MOTIONS):
            self.setUp()
            self.move()
            self.say(WITH_STOP)
            with suppress(AssertionError):
                self.robot.wait_for_state("halted", limit=5)
                break
        self.assertEqual(self.robot.state.halt_reason_code, "stop_topic")
        self.assertEqual(set(self.commands()), {"stop"})

    def test_at_rest_the_same_sentence_does_nothing(self):
        self.say(WITH_STOP)
        self.assertEqual(self.robot.state.state, "active")
        self.assertEqual(self.commands(), [])

    def test_in_motion_a_sentence_without_it_does_nothing(self):
        self.move()
        self.say(WITHOUT)
        self.assertIn(self.robot.state.state, ("moving", "active"))
        self.assertEqual(self.commands(), [])

    def test_a_word_by_hand_puts_the_voice_into_the_robots_mode(self):
        for words, mode in (("terminate", "standby"), ("hey robot", "active")):
            self.robot.say(words)
            self.robot.wait(lambda mode=mode: self.modes[-1:] == [mode], 2.0)


if __name__ == "__main__":
    run_tests(StopInASentence, "stop_in_a_sentence")
