# SPDX-License-Identifier: BSD-3-Clause
"""Reports from the topic that says when a loudspeaker of the robot speaks; the queue is bounded.

Several may speak at once, each reported by a node of its own.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from threading import Lock

from std_msgs.msg import Bool

from voice_assist.audio.robot_speech import RobotSpeechChange
from voice_assist.ros.believed import Believed
from voice_assist.ros.connected import publisher_of

_KEPT = 2  # reports between two takes: the newest, and the one that it changed


class RobotSpeechTopic:
    """Reports received and not yet taken."""

    def __init__(self, clock: Callable[[], float], believed: Believed, max_duration: float) -> None:
        """Subscribe.

        Args:
            clock: Stamps each report [s].
            believed: Makes the subscriber.
            max_duration: After it, speech whose end is never reported is over [s].
        """
        self._clock, self._lock, self._max_duration = clock, Lock(), max_duration
        self._speaking: dict[str, float] = {}  # name of a node: when it reported speech last [s]
        self._reports: deque[RobotSpeechChange] = deque(maxlen=_KEPT)
        believed.hear("speaker", "voice_assist/speaking", Bool, self._hear)

    def take(self) -> list[RobotSpeechChange]:
        """Reports since the last call, oldest first; a repeated report counts once."""
        with self._lock:
            reports = list(self._reports)
            self._reports.clear()
        return reports

    def _hear(self, message: Bool) -> None:
        spoke = RobotSpeechChange(message.data, self._clock())
        with self._lock:
            if self._is_other_left(publisher_of(message), spoke):
                return
            is_again = self._reports and self._reports[-1].is_speaking == spoke.is_speaking
            if is_again and spoke.is_speaking:
                self._reports[-1] = spoke  # speech lasts longer now; a repeated end is dropped
            elif not is_again:
                self._reports.append(spoke)

    def _is_other_left(self, name: str, spoke: RobotSpeechChange) -> bool:
        """Note a report of a node; gives whether it is an end while another node speaks."""
        self._speaking = {
            other: since
            for other, since in self._speaking.items()
            if other != name and abs(spoke.time - since) <= self._max_duration
        }
        if not spoke.is_speaking:
            return bool(self._speaking)
        self._speaking[name] = spoke.time
        return False
