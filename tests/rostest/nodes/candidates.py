#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Commands that the voice node took are passed on as speech_recognition_msgs, nothing else is."""

import subprocess
import unittest

import rospy
from speech_recognition_msgs.msg import SpeechRecognitionCandidates

from support.waiting import wait_until
from tests.support.robot_client import run_tests
from voice_assist.msg import Utterance


class Candidates(unittest.TestCase):
    """What a stranger says, what was refused, what was written otherwise, what was said exactly."""

    def test_only_what_was_taken_is_passed_on_with_its_confidence(self):
        heard = []
        rospy.Subscriber("speech_to_text", SpeechRecognitionCandidates, heard.append)
        words = rospy.Publisher("voice_assist/utterance", Utterance, queue_size=10)
        wait_until(lambda: words.get_num_connections() >= 1)
        said = "{transcript: release, command: release, confidence: 0.9}"
        stranger = ["pub", "-1", "voice_assist/utterance", "voice_assist/Utterance", said]
        subprocess.run(["rostopic", *stranger], check=True, stdout=subprocess.DEVNULL)
        for transcript, command in (("tents", ""), ("hay robot", "hey robot"), ("tense", "tense")):
            words.publish(Utterance(transcript=transcript, command=command, confidence=0.5))
        wait_until(lambda: len(heard) >= 2)
        first, second = heard
        self.assertEqual(first.transcript, ["hey robot", "hay robot"])
        self.assertEqual(tuple(first.confidence), (0.5, 0.5))
        self.assertEqual((second.transcript, tuple(second.confidence)), (["tense"], (0.5,)))


if __name__ == "__main__":
    run_tests(Candidates, "candidates_test")
