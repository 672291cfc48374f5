#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Enrolment as a screen leads it: what to say, what is kept and what is asked for again."""

import os
import shutil
import unittest
from pathlib import Path

import numpy as np
import rospy

from support.waiting import PATIENCE, wait_until
from tests.support.microphone import Microphone
from tests.support.robot_client import run_tests
from voice_assist.msg import Mode
from voice_assist.srv import Enroll
from voice_assist.training.data.voices import HELD_OUT_ACCENT, Prompt, speak
from voice_assist.types import RATE

NOISE = 10.0  # of 32767: a quiet room
DELAY = 1.0  # [s] from the call to the word
FOLDER = Path(os.environ["ROS_HOME"]) / "enrolment_test"  # as nodes.test has it


class EnrolmentByService(unittest.TestCase):
    """The tests run in the order of their names, on one profile."""

    @classmethod
    def setUpClass(cls):
        shutil.rmtree(FOLDER, ignore_errors=True)
        cls.room = Microphone("voice_assist/audio", NOISE)
        cls.mode = rospy.Publisher("voice_assist/mode", Mode, queue_size=1, latch=True)
        cls.mode.publish(Mode(mode="standby"))
        rospy.wait_for_service("voice_assist/enroll", PATIENCE)
        cls.enroll = rospy.ServiceProxy("voice_assist/enroll", Enroll)
        while not cls.mode.get_num_connections():
            rospy.sleep(0.05)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(FOLDER, ignore_errors=True)

    def record(self, text, gain=1.0):
        if text:
            (sound,) = speak([Prompt(text, "espeak", f"{HELD_OUT_ACCENT}+Alex", 1.0, 0.5)])
            self.room.play(np.concatenate([np.zeros(round(DELAY * RATE)), gain * sound]))
        return self.enroll("ada", "record")

    def test_1_it_says_what_to_say_and_records_nothing(self):
        reply = self.enroll("ada", "next")
        self.assertTrue(reply.success, reply.message)
        self.assertEqual((reply.kind, reply.phrase, reply.number), ("room", "", 1))
        self.assertEqual(self.enroll("ada", "next"), reply)

    def test_2_silence_is_the_room_but_no_command_and_asked_for_again(self):
        reply = self.record("")
        self.assertTrue(reply.success, reply.message)
        self.assertEqual((reply.kind, reply.phrase, reply.number), ("command", "hey robot", 1))
        self.assertGreaterEqual(reply.total, 3)
        for text, gain in (("", 1.0), ("hey robot", 0.003)):
            reply = self.record(text, gain)
            self.assertFalse(reply.success)
            self.assertTrue(reply.message)
            self.assertEqual((reply.phrase, reply.number), ("hey robot", 1))

    def test_3_a_good_take_is_kept_and_the_next_one_asked_for(self):
        reply = self.record("hey robot", 0.6)
        self.assertTrue(reply.success, reply.message)
        self.assertNotEqual((reply.phrase, reply.number), ("hey robot", 1))

    def test_4_while_the_robot_listens_to_commands_nothing_is_recorded(self):
        before = self.enroll("ada", "next")
        self.mode.publish(Mode(mode="active"))

        def refusal():  # the mode is on its way
            reply = self.record("")
            return reply if "terminate" in reply.message else None

        reply = wait_until(refusal, "a refusal")
        self.assertFalse(reply.success)
        self.assertEqual((reply.phrase, reply.number), (before.phrase, before.number))
        self.mode.publish(Mode(mode="standby"))

    def test_5_what_makes_no_sense_is_refused_by_name(self):
        self.assertIn("'dance'", self.enroll("ada", "dance").message)
        reply = self.enroll("../../etc", "next")
        self.assertFalse(reply.success)
        self.assertIn("../../etc", reply.message)
        self.assertFalse(self.enroll("ada", "learn").success)  # most takes are missing

    def test_6_recordings_are_for_their_owner_alone(self):
        modes = {path.stat().st_mode & 0o077 for path in FOLDER.rglob("*")}
        self.assertEqual(modes, {0})


if __name__ == "__main__":
    run_tests(EnrolmentByService, "enrolment_test")
