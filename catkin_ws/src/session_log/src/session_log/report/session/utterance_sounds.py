# SPDX-License-Identifier: BSD-3-Clause
"""Cuts each utterance out of the recorded sound while that passes, compressed for a page."""

from __future__ import annotations

import io
from bisect import bisect_left
from collections.abc import Sequence

import numpy as np
import soundfile
from numpy.typing import NDArray

from session_log.report.session.session_data import RecordedUtterance, Track

BEFORE, AFTER = 0.3, 0.2  # [s] of sound that is kept around the words
LONGEST = 20.0  # [s] of one utterance
KEPT = 60.0  # [s] of sound that waits for a decision about it


class UtteranceSounds:
    """The sound of each utterance, as MP3.

    Attributes:
        found: By utterance; one whose sound was not recorded is not in it.
    """

    def __init__(self) -> None:
        self.found: dict[RecordedUtterance, bytes] = {}
        self._times: list[float] = []  # [s] of the first sample of each block
        self._blocks: list[NDArray[np.int16]] = []
        self._wanted: list[RecordedUtterance] = []
        self._rate = 0

    def want(self, utterance: RecordedUtterance) -> None:
        """Keep the sound of an utterance, which may have passed already."""
        self._wanted.append(utterance)

    def hear(self, time: Track, samples: Sequence[NDArray[np.int16]], rate: int) -> None:
        """Take the next blocks of sound.

        Args:
            time: Of each block's first sample [s]. Shape (blocks,).
            samples: Of each block; full scale is 32767.
            rate: Of the samples [Hz].
        """
        self._rate = rate
        self._times += time.tolist()
        self._blocks += samples
        newest = self._times[-1] if self._times else 0.0
        self._cut([u for u in self._wanted if u.speech_end + AFTER <= newest])
        old = bisect_left(self._times, newest - KEPT)
        del self._times[:old], self._blocks[:old]

    def finish(self) -> dict[RecordedUtterance, bytes]:
        """Cut what was still wanted at the end of the recording."""
        self._cut(self._wanted)
        return self.found

    def _cut(self, utterances: Sequence[RecordedUtterance]) -> None:
        for utterance in utterances:
            start = utterance.speech_start - BEFORE
            end = min(utterance.speech_end + AFTER, start + LONGEST)
            first, last = (bisect_left(self._times, time) for time in (start, end))
            parts = self._blocks[first:last]
            if parts and (sound := _compressed(np.concatenate(parts), self._rate)):
                self.found[utterance] = sound
        self._wanted = [u for u in self._wanted if u not in utterances]


def _compressed(samples: NDArray[np.int16], rate: int) -> bytes:
    """As MP3; nothing where that has no such rate."""
    buffer = io.BytesIO()
    try:
        soundfile.write(buffer, samples, rate, format="MP3", subtype="MPEG_LAYER_III")
    except (soundfile.LibsndfileError, ValueError):
        return b""
    return buffer.getvalue()
