# SPDX-License-Identifier: BSD-3-Clause
"""Reads sound files: of any format of libsndfile, whole, or refused in one sentence.

A file is read to its end once before any of it is used. So what is damaged in its middle is found
before a word of it was heard.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import soundfile
import soxr
from numpy.typing import NDArray

from voice_assist.audio import channels
from voice_assist.audio.resample import rate_objection
from voice_assist.errors import AudioError
from voice_assist.types import RATE, Samples

_BLOCK = 1600  # samples read at once, at the file's rate
_LOUDEST = 4.0  # of full scale; decoded sound exceeds 1 a little, integers written as float by far


@dataclass(frozen=True, eq=False)
class SoundFile:
    """A file that was read to its end and is whole."""

    path: Path
    rate: int  # [Hz]
    counts: channels.Weights  # of its channels in the mean

    @property
    def remark(self) -> str:
        """What a person should know of its channels; empty: nothing."""
        return channels.remark(self.counts)

    def blocks(self) -> Iterator[Samples]:
        """Its sound in one channel, at its own rate; shape (n,) each.

        Raises:
            AudioError: It was changed since it was checked.
        """
        with _opened(self.path) as file:
            for block in _blocks(file, self.path):
                yield channels.mix(block, self.counts)


def check_sound(path: str | Path) -> SoundFile:
    """Read a sound file to its end.

    Raises:
        AudioError: It is missing, no sound, damaged or cut off, or its rate or values are none of
            sound.
    """
    path = Path(path)
    with _opened(path) as file:
        if problem := rate_objection(file.samplerate):
            raise AudioError(f"{path}: {problem}")
        sums, read = np.zeros((file.channels, file.channels)), 0
        for block in _blocks(file, path):
            if problem := _objection(block):
                raise AudioError(f"{path}: {problem}, from {read / file.samplerate:.2f} s on")
            sums += channels.products(block)
            read += len(block)
        if read == 0:
            raise AudioError(f"{path}: holds no sound, or is cut off")
        if read < file.frames:
            said, found = file.frames / file.samplerate, read / file.samplerate
            raise AudioError(f"{path}: cut off after {found:.2f} s of {said:.2f} s")
        counts = channels.weights(sums, channels.plain(file.channels))
        return SoundFile(path, int(file.samplerate), counts)


def read_sound(path: str | Path) -> Samples:
    """All of a sound file, 16 kHz mono. Shape (n,).

    Raises:
        AudioError: As `check_sound`.
    """
    file = check_sound(path)
    if file.remark:
        logging.getLogger(__name__).warning("%s: %s", path, file.remark)
    samples = np.concatenate(list(file.blocks()))
    if file.rate != RATE:
        samples = soxr.resample(samples, file.rate, RATE)
    return np.asarray(samples, np.float32)


class _Sequential(soundfile.SoundFile):  # type: ignore[misc]
    """Read from its beginning to its end, without a jump.

    The library else jumps to where it is after each block. In MP3 that damages the sound, and in
    GSM it cannot be done.
    """

    def seekable(self) -> bool:
        """Never."""
        return False


@contextmanager
def _opened(path: Path) -> Iterator[_Sequential]:
    if not path.is_file():
        raise AudioError(f"{path}: {'not a file' if path.exists() else 'no such file'}")
    try:
        file = _Sequential(str(path))
    except (soundfile.LibsndfileError, RuntimeError) as error:
        raise AudioError(f"{path}: not a sound file that can be read ({error})") from error
    with file:
        yield file


def _blocks(file: _Sequential, path: Path) -> Iterator[NDArray[np.float32]]:
    """Of shape (n, channels)."""
    read = 0
    while True:
        try:
            block = file.read(_BLOCK, dtype="float32", always_2d=True)
        except (soundfile.LibsndfileError, RuntimeError) as error:
            at = read / file.samplerate
            raise AudioError(f"{path}: damaged after {at:.2f} s ({error})") from error
        if not len(block):
            return
        read += len(block)
        yield block


def _objection(block: NDArray[np.float32]) -> str:
    if not np.isfinite(block).all():
        return "values that are no numbers"
    peak = float(np.abs(block).max())
    if peak > _LOUDEST:
        return f"values up to {peak:.6g}, allowed: -1 to 1, as of float samples"
    return ""
