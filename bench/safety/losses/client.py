# SPDX-License-Identifier: BSD-3-Clause
"""Who may give commands and be lost: an action client of its own process, and a voice in a room."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time
from typing import Self

import numpy as np
import rospy
from numpy.typing import NDArray

from bench.safety.losses.parts import SIGNALS
from support.theatre_sound import RATE, speak
from voice_assist.msg import AudioChunk

CONNECT_TIME = 30.0  # [s] for the client to find the controller
FOUND = "found\n"  # what it says then
CHUNK = RATE // 20  # samples of one message of sound
QUIET = 1e-3  # RMS of the quiet room, full scale 1
VOICE, WORDS_PER_MINUTE = "en-us+f2", 150


class ActionClient:
    """A process that sends goals of `rst_control/execute`; the same calls as a part's."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None

    def start(self) -> None:
        """Start it and wait until it has found the controller.

        Raises:
            RuntimeError: It has not.
        """
        self._process = subprocess.Popen(
            (sys.executable, "-m", "bench.safety.losses.client"),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        lines = self._process.stdout
        if lines is None or FOUND not in iter(lines.readline, ""):
            raise RuntimeError("the action client did not find the controller")

    def send(self, words: str, tension: float) -> None:
        """Let it send a goal."""
        if self._process is not None and self._process.stdin is not None:
            self._process.stdin.write(f"{tension} {words}\n")
            self._process.stdin.flush()

    def lose(self, way: str) -> float:
        """Send SIGKILL or SIGSTOP; gives when [s], time.monotonic()."""
        moment = time.monotonic()
        self._signal(SIGNALS[way])
        return moment

    def give_back(self, way: str) -> float:
        """Let it go on, or start it anew; gives when it began to [s]."""
        if way == "SIGSTOP":
            moment = time.monotonic()
            self._signal(signal.SIGCONT)
            return moment
        self.end()
        moment = time.monotonic()
        self.start()
        return moment

    def end(self) -> None:
        """End it."""
        if self._process is not None:
            self._signal(signal.SIGKILL)
            self._process.wait(5.0)

    def _signal(self, number: signal.Signals) -> None:
        if self._process is not None:
            self._process.send_signal(number)


def _client() -> None:
    """The client, in its own process: goals come as lines, tension [N] and words."""
    import actionlib

    from rst_control.msg import AssistAction, AssistGoal

    rospy.init_node("losses_client", anonymous=True, disable_signals=True, disable_rosout=True)
    client = actionlib.SimpleActionClient("rst_control/execute", AssistAction)
    if client.wait_for_server(rospy.Duration(CONNECT_TIME)):
        print(FOUND, end="", flush=True)
    for line in sys.stdin:
        tension, words = line.rstrip("\n").split(" ", 1)
        client.send_goal(AssistGoal(words, float(tension), 0.0))


class SpeechSource:
    """A quiet room on the topic `audio_in` in which somebody may speak; a context manager."""

    def __init__(self) -> None:
        self._publisher = rospy.Publisher("audio_in", AudioChunk, queue_size=10)
        self._noise = np.random.default_rng(6)
        self._lock, self._over = threading.Lock(), threading.Event()
        self._to_say: NDArray[np.float32] = np.empty(0, np.float32)
        self._spoken: dict[str, NDArray[np.float32]] = {}
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    def say(self, words: str, voice: str = VOICE, pace: int = WORDS_PER_MINUTE) -> None:
        """Speak, from the next block of sound on; `pace` in words per minute."""
        key = f"{words} {voice} {pace}"
        if key not in self._spoken:
            self._spoken[key] = speak(words, voice, pace)
        with self._lock:
            self._to_say = self._spoken[key]

    def _run(self) -> None:
        begin, first = time.monotonic(), 0
        while not self._over.wait(max(0.0, begin + (first + CHUNK) / RATE - time.monotonic())):
            sound = QUIET * self._noise.standard_normal(CHUNK)
            with self._lock:
                piece, self._to_say = self._to_say[:CHUNK], self._to_say[CHUNK:]
            sound[: len(piece)] += piece
            samples = (np.clip(sound, -1.0, 1.0) * 32767).astype(np.int16)
            chunk = AudioChunk(rate=RATE, first_sample=first, samples=samples.tolist())
            chunk.header.stamp = rospy.Time.from_sec(time.time() - CHUNK / RATE)
            self._publisher.publish(chunk)
            first += CHUNK


if __name__ == "__main__":
    _client()
