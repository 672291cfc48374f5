# SPDX-License-Identifier: BSD-3-Clause
"""Recorded sound by its sample indices: where runs of the voice node begin, and what is lost."""

from __future__ import annotations

import wave
from array import array
from errno import EFBIG
from pathlib import Path

from session_log.errors import OutputFailed

NANOSECONDS = 1_000_000_000
MOST_SILENCE = 57_600_000  # samples in a file: an hour at 16 kHz, 115 MB
MOST_RATE = (1 << 31) - 1  # [Hz] the file has 4 bytes for twice the rate
MOST_SOUND = (1 << 32) - 64  # [B] it has 4 bytes for its size, head included
_BLOCK = 1 << 16  # samples that are written at once


class StreamWatch:
    """Follows the sample indices: where a run of the node begins, and where sound is missing."""

    def __init__(self) -> None:
        self._expected: int | None = None

    def __call__(self, first_sample: int, length: int) -> tuple[bool, int]:
        """Whether a run begins with this block, and how many samples are missing before it."""
        expected, self._expected = self._expected, first_sample + length
        if expected is None or first_sample < expected:
            return True, first_sample
        return False, first_sample - expected


class SoundFile:
    """The sound as it was recorded; what is missing becomes silence.

    Within a run of the node the indices of the samples tell how much that is, between two runs
    their stamps.

    Args:
        path: Of the WAV file.
        rate: Of the samples [Hz].

    Attributes:
        rate: The same.
        start: When the first sample was captured [ns].
        samples: How many were recorded.
        lost: How many are missing.
        unfilled: How many of those have no silence in their place: there were too many.
    """

    def __init__(self, path: Path, rate: int) -> None:
        self.path, self.rate = path, rate
        self.start = self.samples = self.lost = self.unfilled = 0
        self._end = 0  # [ns] when the next sample is due
        self._size = 0  # [B]
        self._watch = StreamWatch()
        self._file = wave.open(str(path), "wb")  # noqa: SIM115 - closed in __exit__
        self._file.setnchannels(1)
        self._file.setsampwidth(2)
        self._file.setframerate(rate)

    def add(self, first: int, samples: array[int], time: int) -> None:
        """Take the next block of sound.

        Args:
            first: Index of its first sample in its run.
            samples: Shape (n,).
            time: When the first of them was captured [ns].

        Raises:
            OutputFailed: There is more sound than the file can hold; what is in it stays.
        """
        is_new, missing = self._watch(first, len(samples))
        if is_new:
            missing = max((time - self._end) * self.rate // NANOSECONDS, 0)
        if self.samples:
            self._fill(missing)
        else:
            self.start = time
        self._end = time + len(samples) * NANOSECONDS // self.rate
        self._write(samples.tobytes())
        self.samples += len(samples)

    def _fill(self, missing: int) -> None:
        silence = min(missing, MOST_SILENCE - (self.lost - self.unfilled))
        self.lost += missing
        self.unfilled += missing - silence
        for begin in range(0, silence, _BLOCK):
            self._write(bytes(2 * min(_BLOCK, silence - begin)))

    def _write(self, sound: bytes) -> None:
        if self._size + len(sound) > MOST_SOUND:
            words = "more sound than the 4 GiB that a WAV file can hold"
            raise OutputFailed(self.path, OSError(EFBIG, words))
        self._file.writeframes(sound)
        self._size += len(sound)

    def __enter__(self) -> SoundFile:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()
