# SPDX-License-Identifier: BSD-3-Clause
"""A microphone for the rostests: speech in a quiet room, on the voice node's audio topic."""

from __future__ import annotations

import threading

import numpy as np
import rospy

from support.theatre_sound import speak
from voice_assist.audio.source import FRAME
from voice_assist.msg import AudioChunk
from voice_assist.types import FULL_SCALE, RATE


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
