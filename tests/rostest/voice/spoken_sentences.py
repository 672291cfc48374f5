#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""From sound to a robot that stops, goes for an amount, or does neither.

The same sentences are said at rest and in motion.
"""

import json
from contextlib import suppress

import rospy

from support.waiting import wait_until
from tests.support.microphone import Microphone
from tests.support.robot_client import RobotTest, run_tests
from typed_config.ros.launch_settings import KEPT, differences
from voice_assist.msg import Mode, Utterance

READY = 120.0  # [s] allowed for the voice node to listen
AGAIN = 6.0  # [s] after which it is spoken to again
HEARD = 15.0  # [s] allowed for a decision after the end of a sentence
WITH_STOP, WITHOUT = "he said stop and went on", "he said pull more and went on"
MOTIONS = 3
BY_VOICE = ("stop_topic", "stop_command")  # it is said both ways; either may be there first
SAID, SENT, TARGET = "tension one point five", "tense 1.5 N", 1.5  # [N]
NEAR = ("tension one point nine", "the tension is one point five")


class SpokenSentences(RobotTest):
    """Each test begins with a robot that is active; `heard` holds what was decided since then.

    More of them: test_stop_in_motion.py, and the bench. Amounts are on in this launch.
    """

    @classmethod
    def setUpClass(cls):
        cls.heard, cls.modes = [], []
        rospy.Subscriber("voice_assist/mode", Mode, lambda m: cls.modes.append(m.mode))
        super().setUpClass()
        cls.microphone = Microphone()
        rospy.Subscriber("voice_assist/utterance", Utterance, cls.heard.append)
        cls.robot.start_fresh()
        end = rospy.get_time() + READY
        while not cls.heard and rospy.get_time() < end:
            cls.microphone.say("good morning")
            with suppress(RuntimeError):
                wait_until(lambda: cls.heard, limit=AGAIN)
        assert cls.heard, "the voice node hears nothing"

    @classmethod
    def tearDownClass(cls):
        cls.microphone.timer.shutdown()
        super().tearDownClass()

    def setUp(self):
        self.robot.start_fresh()
        self.heard.clear()

    def say(self, words):
        """Say a sentence; returns what was decided about it, and what followed had its time."""
        self.heard.clear()
        self.microphone.say(words)
        self.robot.wait(lambda: self.heard, HEARD)
        rospy.sleep(0.5)
        return self.heard[-1]

    def commands(self):
        return [one.command for one in self.heard if one.command]

    def move(self):
        self.robot.say("tense")
        self.robot.wait_for_state("moving")

    def test_no_node_changes_the_settings_of_its_launch(self):
        """The controller would latch, as where a person changes them."""
        tree = rospy.get_param("/").items()
        nodes = {name: of for name, of in tree if isinstance(of, dict) and KEPT in of}
        self.assertLessEqual({"controller", "robot", "voice_assist"}, nodes.keys())
        for name, settings in nodes.items():
            launched = json.loads(settings[KEPT])
            present = {key: settings.get(key) for key in launched}
            self.assertEqual(differences(launched, present), [], name)

    def test_in_motion_a_stop_in_a_sentence_stops(self):
        """In one of three motions: how often it is heard is what `voice.overlap` measures."""
        for _ in range(MOTIONS):
            self.setUp()
            self.move()
            self.say(WITH_STOP)
            with suppress(AssertionError):
                self.robot.wait_for_state("halted", limit=5)
                break
        self.assertEqual(self.robot.state.state, "halted")
        self.assertIn(self.robot.state.halt_reason_code, BY_VOICE)
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
            self.robot.wait(lambda mode=mode: self.modes[-1:] == [mode])

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

    def test_near_misses_of_an_amount_move_nothing(self):
        events = len(self.robot.events)
        for words in NEAR:
            decided = self.say(words)
            self.assertEqual(decided.command, "", decided)
        self.assertEqual(self.robot.state.state, "active")
        since = self.robot.events[events:]  # with those of the "hey robot" before, maybe
        self.assertEqual([e.kind for e in since if e.command != "hey robot"], [])


if __name__ == "__main__":
    run_tests(SpokenSentences, "spoken_sentences")
