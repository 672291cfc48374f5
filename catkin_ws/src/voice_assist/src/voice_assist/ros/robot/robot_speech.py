# SPDX-License-Identifier: BSD-3-Clause
"""Reports from the topic that says when the robot's loudspeaker speaks; the queue is bounded."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from threading import Lock

from std_msgs.msg import Bool

from voice_assist.audio.robot_speech import RobotSpeechChange
from voice_assist.ros.believed import Believed

_KEPT = 2  # reports between two takes: the newest, and the one that it changed


class RobotSpeechTopic:
    """Reports received and not yet taken."""

    def __init__(self, clock: Callable[[], float], believed: Believed) -> None:
        """Subscribe; `clock` stamps each report [s]."""
        self._clock, self._lock = clock, Lock()
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
            is_again = self._reports and self._reports[-1].is_speaking == spoke.is_speaking
            if is_again and spoke.is_speaking:
                self._reports[-1] = spoke  # speech lasts longer now; a repeated end is dropped
            elif not is_again:
                self._reports.append(spoke)
