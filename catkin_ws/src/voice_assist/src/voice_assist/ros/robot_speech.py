# SPDX-License-Identifier: BSD-3-Clause
"""Hears by topic when a loudspeaker of the robot speaks; however often, it stays short."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from threading import Lock

import rospy
from std_msgs.msg import Bool

from voice_assist.audio.robot_speech import Spoke

_LEFT = 2  # of what was told between two looks: the newest, and what it changed


class SpeakingTopic:
    """What was told and not yet taken."""

    def __init__(self, clock: Callable[[], float]) -> None:
        """Subscribe; `clock` stamps what is told [s]."""
        self._clock, self._lock = clock, Lock()
        self._told: deque[Spoke] = deque(maxlen=_LEFT)
        rospy.Subscriber("voice_assist/speaking", Bool, self._hear)

    def take(self) -> list[Spoke]:
        """What was told since the last look, oldest first; the same told again counts once."""
        with self._lock:
            told = list(self._told)
            self._told.clear()
        return told

    def _hear(self, message: Bool) -> None:
        spoke = Spoke(message.data, self._clock())
        with self._lock:
            is_again = self._told and self._told[-1].is_speaking == spoke.is_speaking
            if is_again and spoke.is_speaking:
                self._told[-1] = spoke  # it lasts longer now; an end told again is none
            elif not is_again:
                self._told.append(spoke)
