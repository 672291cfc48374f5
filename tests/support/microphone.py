# SPDX-License-Identifier: BSD-3-Clause
"""A room on a topic, for rostests that speak to a running system."""

from __future__ import annotations

import threading

import numpy as np
import rospy
from numpy.typing import NDArray

from support.theatre_sound import speak
from voice_assist.audio.source import FRAME
from voice_assist.msg import AudioChunk
from voice_assist.types import FULL_SCALE, RATE


class Microphone:
    """A quiet room, in real time, in which sounds are played and sentences are said.

    Args:
        topic: That its sound is published on.
        noise: Of the room, its standard deviation [of 32767].
    """

    def __init__(self, topic: str = "audio_in", noise: float = 3.0) -> None:
        self.topic = rospy.Publisher(topic, AudioChunk, queue_size=100)
        self.waiting, self.lock, self.sent = np.zeros(0), threading.Lock(), 0
        self.noise, self.rng = noise, np.random.default_rng(0)
        self.timer = rospy.Timer(rospy.Duration(FRAME / RATE), self.send)

    def play(self, sound: NDArray[np.floating]) -> None:
        """Play a sound [of 32767] after those before it; returns at once."""
        with self.lock:
            self.waiting = np.concatenate([self.waiting, sound])

    def say(self, words: str) -> None:
        """Say them; returns when the last of it was sent."""
        self.play(speak(words, "en-us", 150) * FULL_SCALE)
        while len(self.waiting):
            rospy.sleep(0.02)

    def send(self, _: object) -> None:
        """Send one block; the timer's callback."""
        with self.lock:
            said, self.waiting = self.waiting[:FRAME], self.waiting[FRAME:]
        block = self.noise * self.rng.standard_normal(FRAME)
        block[: len(said)] += said
        samples = np.clip(np.round(block), -FULL_SCALE, FULL_SCALE).astype(np.int16)
        chunk = AudioChunk(rate=RATE, first_sample=self.sent, samples=samples.tolist())
        chunk.header.stamp = rospy.Time.now()
        self.topic.publish(chunk)
        self.sent += FRAME
