# SPDX-License-Identifier: BSD-3-Clause
"""When the robot's own loudspeaker speaks, as the programs report that let it speak.

What it says may quote commands, and the microphone hears it. It can neither move nor wake the
robot; a "stop" counts from anyone. One that a person says over it is no utterance of its own. So
meanwhile each decoder pass takes the last `window` alone, too.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from voice_assist.config.voice import RobotSpeechConfig

SET_BACK: Final = 30.0  # [s] before its voice, in which no utterance begins but by another clock


@dataclass(frozen=True)
class RobotSpeechChange:
    """A loudspeaker of the robot began to speak, or ended."""

    is_speaking: bool
    time: float  # [s] clock time at which it was reported


class RobotSpeech:
    """Follows what is reported of the loudspeaker."""

    def __init__(self, config: RobotSpeechConfig) -> None:
        """Nobody speaks."""
        self._config = config
        self.reset()

    def reset(self) -> None:
        """Nobody speaks, nor did."""
        self._since = float("-inf")  # [s] clock time from which on it spoke last
        self._until = float("-inf")  # [s] clock time up to which it may be heard

    def update(self, change: RobotSpeechChange) -> None:
        """Follow; where its end is never reported, it counts as over after `max_duration`."""
        if change.is_speaking:
            self._since, self._until = change.time, change.time + self._config.max_duration
        else:
            self._until = min(self._until, change.time + self._config.tail)

    def is_in(self, speech_start: float) -> bool:
        """Whether it may be in speech that began at a clock time [s] and reaches until now."""
        return self._since - SET_BACK <= speech_start <= self._until
