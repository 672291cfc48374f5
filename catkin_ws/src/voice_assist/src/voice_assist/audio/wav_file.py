# SPDX-License-Identifier: BSD-3-Clause
"""A recording in place of a microphone, in real time or faster."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from voice_assist.audio.resample import Resampler
from voice_assist.audio.sound_file import SoundFile, check_sound
from voice_assist.audio.source import FRAME, Clock, Framer
from voice_assist.errors import AudioError
from voice_assist.types import RATE, Frame, Samples

Wait = Callable[[float], object]  # pauses for so many seconds


class WavFile:
    """Frames of a sound file of any format of libsndfile."""

    def __init__(
        self,
        path: str | Path,
        clock: Clock,
        wait: Wait,
        *,
        speed: float = 1.0,
        then_silence: bool = False,
    ) -> None:
        """Remember what to play.

        Args:
            path: The file.
            clock: Gives the stamps of the frames [s].
            wait: Pauses for so many seconds; never called where speed is 0.
            speed: Times real time; 0: as fast as the frames are taken.
            then_silence: Go on with silence for ever after the end of the file.
        """
        self._path, self._clock, self._wait = Path(path), clock, wait
        self._speed, self._then_silence = speed, then_silence
        self._file: SoundFile | None = None

    @property
    def remark(self) -> str:
        """What a person should know of its channels; empty: nothing."""
        return "" if self._file is None else self._file.remark

    def __enter__(self) -> WavFile:
        """Check the file.

        Raises:
            AudioError: It cannot be read to its end.
        """
        self._file = check_sound(self._path)
        return self

    def __exit__(self, *_: object) -> None:
        """Forget the file."""
        self._file = None

    def __iter__(self) -> Iterator[Frame]:
        """Give each frame when its last sample would have been heard."""
        start = self._clock()
        frames = self._frames()
        for number, samples in enumerate(frames):
            if self._speed:
                due = start + (number + 1) * FRAME / RATE / self._speed
                if (ahead := due - self._clock()) > 0:
                    self._wait(ahead)
                yield Frame(samples, number * FRAME, due - FRAME / RATE)
            else:
                yield Frame(samples, number * FRAME, start + number * FRAME / RATE)

    def _frames(self) -> Iterator[Samples]:
        if self._file is None:
            raise AudioError(f"{self._path} is not open; enter the source first")
        framer = Framer()
        resample = Resampler(self._file.rate)
        for block in self._file.blocks():
            yield from (f.samples for f in framer.push(resample(block), 0.0))
        last = resample(np.zeros(0, np.float32), is_last=True)
        yield from (f.samples for f in framer.push(last, 0.0))
        yield from (f.samples for f in framer.flush())
        silence = np.zeros(FRAME, np.float32)
        silence.flags.writeable = False
        while self._then_silence:
            yield silence
