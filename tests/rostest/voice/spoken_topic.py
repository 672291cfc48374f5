# SPDX-License-Identifier: BSD-3-Clause
"""A microphone for the rostests, and a test that speaks to a running system through it."""

from __future__ import annotations

import threading

import numpy as np
import rospy

from support.theatre_sound import speak
from tests.support.robot_client import RobotTest
from voice_assist.audio.source import FRAME
from voice_assist.msg import AudioChunk, Utterance
from voice_assist.types import FULL_SCALE, RATE

READY = 120.0  # [s] allowed for the voice node to listen
HEARD = 15.0  # [s] allowed for a decision after the end of a sentence


class Microphone:
    """A quiet room on the audio topic, in real time, in which sentences are said."""

    def __init__(self) -> None:
        self.topic = rospy.Publisher("audio_in", AudioChunk, queue_size=100)
        self.waiting, self.lock, self.sent = np.zeros(0, np.int16), threading.Lock(), 0
        self.noise = np.random.default_rng(0)
        self.timer = rospy.Timer(rospy.Duration(FRAME / RATE), self.send)

    def say(self, words: str) -> None:
        """Say them; returns when the last of it was sent."""
        sound = np.round(speak(words, "en-us", 150) * FULL_SCALE).astype(np.int16)
        with self.lock:
            self.waiting = np.concatenate([self.waiting, sound])
        while len(self.waiting):
            rospy.sleep(0.02)

    def send(self, _: object) -> None:
        """Send one block; the timer's callback."""
        with self.lock:
            said, self.waiting = self.waiting[:FRAME], self.waiting[FRAME:]
        block = np.round(3.0 * self.noise.standard_normal(FRAME)).astype(np.int16)
        block[: len(said)] += said
        chunk = AudioChunk(rate=RATE, first_sample=self.sent, samples=block.tolist())
        chunk.header.stamp = rospy.Time.now()
        self.topic.publish(chunk)
        self.sent += FRAME


class SpokenTo(RobotTest):
    """Each test begins with a robot that is active; `heard` holds what was decided since then."""

    @classmethod
    def setUpClass(cls) -> None:
        super().setUpClass()
        cls.microphone, cls.heard = Microphone(), []
        rospy.Subscriber("voice_assist/utterance", Utterance, cls.heard.append)
        cls.robot.start_fresh()
        end = rospy.get_time() + READY
        while not cls.heard and rospy.get_time() < end:
            cls.microphone.say("good morning")
            rospy.sleep(2.0)
        assert cls.heard, "the voice node hears nothing"

    @classmethod
    def tearDownClass(cls) -> None:
        cls.microphone.timer.shutdown()
        super().tearDownClass()

    def setUp(self) -> None:
        self.robot.start_fresh()
        self.heard.clear()

    def say(self, words: str) -> Utterance:
        """Say a sentence; returns what was decided about it, and what followed had its time."""
        self.heard.clear()
        self.microphone.say(words)
        self.robot.wait(lambda: self.heard, HEARD)
        rospy.sleep(0.5)
        return self.heard[-1]
