# SPDX-License-Identifier: BSD-3-Clause
"""Frames and endpoints to utterances that grow frame by frame."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from voice_assist.config import VadConfig
from voice_assist.types import RATE, Frame, Samples, Utterance, frozen_samples
from voice_assist.vad.endpointer import Endpoint, SpeechState

_KEPT_FRAMES = 4  # of the quiet that ended an utterance, since the next one may begin in it


@dataclass(frozen=True, eq=False)
class PartialUtterance:
    """An utterance with its newest frame."""

    utterance: Utterance
    quiet: float  # [s] since the last speech
    is_whole: bool  # nothing was said in the same breath before it
    clearness: float  # highest probability of speech in it, [0, 1]


class Segmenter:
    """Keeps the sound of the utterance in progress, with some from before its first speech."""

    def __init__(self, config: VadConfig) -> None:
        """Start with nothing heard."""
        self._config = config
        self.reset()

    def reset(self) -> None:
        """Forget all sound; what is heard next may be the rest of something longer."""
        self._before: deque[Frame] = deque()
        self._frames: list[Frame] = []
        self._is_open = False
        self._is_whole = True
        self._speech_start = self._speech_end = 0.0
        self._broken_at: float | None = None

    def break_at(self, stamp: float) -> None:
        """Forget all sound after a gap that ended at a clock time [s]."""
        self.reset()
        self._broken_at = stamp

    def __call__(self, frame: Frame, endpoint: Endpoint) -> PartialUtterance | None:
        """Take a frame; gives the utterance it belongs to, or none in quiet."""
        if not self._is_open:
            self._remember(frame)
            if not endpoint.is_start:
                return None
            self._begin(frame, endpoint)
        else:
            self._frames.append(frame)
        if endpoint.quiet == 0.0:
            self._speech_end = frame.end
        is_complete = endpoint.is_end or self._length() >= self._config.max_utterance
        samples = frozen_samples(np.concatenate([f.samples for f in self._frames]))
        utterance = Utterance(samples, self._speech_start, self._speech_end, is_complete)
        partial = PartialUtterance(utterance, endpoint.quiet, self._is_whole, endpoint.clearness)
        if is_complete:
            self._end(frame, endpoint)
        return partial

    def restart(self, keep: float) -> None:
        """Go on with the rest of the utterance only, after a decision about its beginning.

        Args:
            keep: Of the newest sound that belongs to the rest [s].
        """
        if self._is_open and self._frames:
            self._keep(keep)
            self._is_whole = False

    def forget(self, keep: float) -> None:
        """Drop the beginning: nothing was said in it, and what follows is a breath of its own.

        Args:
            keep: Of the newest sound, which may begin a word [s].
        """
        if self._is_open and self._frames:
            self._keep(keep)
            self._is_whole = True
            if self._frames:
                self._speech_start = max(self._speech_start, self._frames[0].stamp)

    def _keep(self, seconds: float) -> None:
        frames = self._frames
        count = min(round(seconds * RATE / len(frames[-1].samples)), len(frames))
        self._frames = frames[len(frames) - count :]

    def _remember(self, frame: Frame) -> None:
        """Ring of the newest frames: pre-roll and what may become speech."""
        self._before.append(frame)
        longest = self._config.pre_roll + self._config.min_speech + 2 * frame.duration
        while sum(f.duration for f in self._before) > longest:
            self._before.popleft()

    def _begin(self, frame: Frame, endpoint: Endpoint) -> None:
        start = frame.end - endpoint.spoken
        earliest = start - self._config.pre_roll
        self._frames = [f for f in self._before if f.end > earliest]
        self._speech_start, self._is_open = start, True
        is_rest = self._broken_at is not None and start - self._broken_at < self._config.hangover
        self._is_whole, self._broken_at = not is_rest, None

    def _end(self, frame: Frame, endpoint: Endpoint) -> None:
        self._is_open = endpoint.state in (SpeechState.SPEAKING, SpeechState.STOPPING)
        self._is_whole = not self._is_open
        self._before = deque(self._frames[-_KEPT_FRAMES:])
        self._frames = []
        self._speech_start = frame.end

    def _length(self) -> float:
        return sum(len(f.samples) for f in self._frames) / RATE


def last(samples: Samples, seconds: float) -> Samples:
    """The newest part of sound, at most so long."""
    return samples[-round(seconds * RATE) :]
