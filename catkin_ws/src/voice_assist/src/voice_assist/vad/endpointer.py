# SPDX-License-Identifier: BSD-3-Clause
"""Endpointing: four states over a stream of speech probabilities."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from voice_assist.config import VadConfig

_SLACK = 1e-9  # [s] so that sums of frame lengths reach their limits


class SpeechState(Enum):
    """Where in an utterance the stream is."""

    QUIET = "quiet"
    STARTING = "starting"  # maybe speech, not yet long enough
    SPEAKING = "speaking"
    STOPPING = "stopping"  # quiet, not yet long enough to be the end


@dataclass(frozen=True)
class Endpoint:
    """What one more frame showed."""

    state: SpeechState
    is_start: bool  # an utterance was confirmed with this frame
    is_end: bool  # an utterance was ended by this frame
    quiet: float  # [s] since the last speech frame
    spoken: float  # [s] since the first speech frame of this utterance
    clearness: float  # highest probability of speech in this utterance, [0, 1]


class Endpointer:
    """Follows the probability of speech with three thresholds and two times.

    One is for the beginning. Where an utterance ends, and goes on after all, is measured by the
    highest probability so far: in loud noise the detector is never sure of speech, and never sure
    that it has ended.
    """

    def __init__(self, config: VadConfig) -> None:
        """Start in quiet."""
        self._config = config
        self.reset()

    def reset(self) -> None:
        """Forget the utterance so far."""
        self._state = SpeechState.QUIET
        self._quiet = self._spoken = 0.0
        self._peak = 0.0  # highest probability of this utterance

    def __call__(self, probability: float, duration: float) -> Endpoint:
        """Take the next frame.

        Args:
            probability: That it holds speech, [0, 1].
            duration: Its length [s].
        """
        before = self._state
        is_speech = probability >= self._threshold()
        self._peak = max(probability, 0.0 if before is SpeechState.QUIET else self._peak)
        self._quiet = 0.0 if is_speech else self._quiet + duration
        self._spoken = duration if self._begins(is_speech) else self._spoken + duration
        self._state = self._next(is_speech)
        return Endpoint(
            self._state,
            is_start=self._is_heard(self._state) and not self._is_heard(before),
            is_end=self._is_heard(before) and not self._is_heard(self._state),
            quiet=self._quiet,
            spoken=self._spoken if self._state is not SpeechState.QUIET else 0.0,
            clearness=self._peak,
        )

    def _threshold(self) -> float:
        """Of the probability from which this frame is speech, by where in an utterance it is."""
        config, state = self._config, self._state
        if state is SpeechState.QUIET:
            return config.start
        held = config.stop * self._peak
        if state is SpeechState.STARTING:
            return min(config.start, held)
        return held if state is SpeechState.SPEAKING else config.resume * self._peak

    def _begins(self, is_speech: bool) -> bool:
        return is_speech and self._state is SpeechState.QUIET

    def _next(self, is_speech: bool) -> SpeechState:
        if self._is_heard(self._state):
            if is_speech:
                return SpeechState.SPEAKING
            is_over = self._quiet >= self._config.hangover - _SLACK
            return SpeechState.QUIET if is_over else SpeechState.STOPPING
        if not is_speech:
            return SpeechState.QUIET
        is_enough = self._spoken >= self._config.min_speech - _SLACK
        return SpeechState.SPEAKING if is_enough else SpeechState.STARTING

    @staticmethod
    def _is_heard(state: SpeechState) -> bool:
        return state in (SpeechState.SPEAKING, SpeechState.STOPPING)
