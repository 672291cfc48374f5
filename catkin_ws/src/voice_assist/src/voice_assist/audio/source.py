# SPDX-License-Identifier: BSD-3-Clause
"""What every source of sound is, and the frames it gives."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from voice_assist.types import FULL_SCALE, RATE, Frame, Samples, frozen_samples

MIN_GAP: Final = RATE // 10  # samples of a gap where two clocks cannot say how long it was
FRAME = 512  # samples, 32 ms; the size that the Silero detector takes

Clock = Callable[[], float]  # [s]
Report = Callable[[str], None]  # takes in words what goes wrong and right again


class AudioSource(Protocol):
    """A context manager that gives frames until the sound ends."""

    def __enter__(self) -> AudioSource:
        """Open the source."""
        ...

    def __exit__(self, *_: object) -> None:
        """Close the source."""
        ...

    @property
    def remark(self) -> str:
        """What a person should know of the sound that comes; empty: nothing."""
        ...

    def __iter__(self) -> Iterator[Frame]:
        """Frames of FRAME samples, in order, 16 kHz mono."""
        ...


class Framer:
    """Cuts blocks of any size into frames of FRAME samples, on the grid of 16-bit sound.

    So a recording of the frames as 16-bit sound holds exactly what was heard, and hearing it again
    gives the same decisions.
    """

    def __init__(self) -> None:
        """Start a stream at sample 0."""
        self._rest: Samples = np.zeros(0, np.float32)
        self._stamp = 0.0  # [s] of the first sample in the rest
        self._next = 0  # index of the first sample in the rest

    def push(self, samples: NDArray[np.generic], stamp: float) -> Iterator[Frame]:
        """Add a block and give the frames that are complete.

        Args:
            samples: Float or int16, 16 kHz mono. Shape (n,).
            stamp: Clock time of the first sample [s].
        """
        self._stamp = stamp - len(self._rest) / RATE
        self._rest = np.concatenate([self._rest, _on_grid(frozen_samples(samples))])
        while len(self._rest) >= FRAME:
            yield Frame(frozen_samples(self._rest[:FRAME]), self._next, self._stamp)
            self._advance(FRAME)

    def skip(self, samples: int) -> None:
        """Leave a gap of so many lost samples; an incomplete frame is lost with them."""
        if samples > 0:
            self._next += len(self._rest) + samples
            self._rest = np.zeros(0, np.float32)

    def flush(self) -> Iterator[Frame]:
        """Give what is left, padded with silence to a whole frame."""
        if len(self._rest):
            padded = np.zeros(FRAME, np.float32)
            padded[: len(self._rest)] = self._rest
            yield Frame(frozen_samples(padded), self._next, self._stamp)
            self._next += FRAME
            self._rest = np.zeros(0, np.float32)

    def _advance(self, samples: int) -> None:
        self._rest = self._rest[samples:]
        self._next += samples
        self._stamp += samples / RATE


def _on_grid(samples: Samples) -> Samples:
    scaled = np.rint(np.clip(samples, -1.0, 1.0) * FULL_SCALE)
    return np.asarray(scaled / np.float32(FULL_SCALE), np.float32)


class GapWatch:
    """Notices samples that are missing between frames."""

    def __init__(self) -> None:
        """Expect a stream to begin anywhere."""
        self._expected: int | None = None

    def __call__(self, frame: Frame) -> int | None:
        """Samples lost before this frame; None: none; 0: the stream began anew."""
        expected, self._expected = self._expected, frame.next_sample
        if expected is None or expected == frame.first_sample:
            return None
        return max(frame.first_sample - expected, 0)


def level_db(samples: NDArray[np.float32]) -> float:
    """Root mean square in dB of full scale, at least -100."""
    if not len(samples):
        return -100.0
    power = float(np.mean(np.square(samples, dtype=np.float64)))
    return 10.0 * float(np.log10(max(power, 1e-10)))
