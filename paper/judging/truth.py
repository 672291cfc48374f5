# SPDX-License-Identifier: BSD-3-Clause
"""When a phrase truly sounded: the sound that was played, found again in what was captured.

Neither the speech detector nor the recogniser has a say in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import correlate

from session_log.mcap_file.decoder import Decoder
from session_log.mcap_file.reader import SessionReader
from voice_assist.audio.mixing import end_of_speech
from voice_assist.types import RATE

AUDIO = "/voice_assist/audio"
EARLY, LATE = 0.1, 1.0  # [s] before the player's start and after its end in which is searched
WHOLE = 0.88  # correlation from which a phrase was heard whole; over 15 dB it is 0.91 to 0.98


@dataclass(frozen=True)
class SoundBlock:
    """One block of what the voice node heard."""

    stamp: float  # [s] when the first sample was captured
    first: int  # index of the first sample
    samples: NDArray[np.int16]  # (n,), 16 kHz mono


@dataclass(frozen=True)
class Sounded:
    """One phrase at the microphone."""

    begin: float  # [s] since 1970, its first sample
    end: float  # [s] its last audible moment
    likeness: float  # [-1, 1] correlation of what was played with what was captured


def captured_sound(folder: Path) -> list[SoundBlock]:
    """All sound of a recording, in order of time.

    Raises:
        SessionMissing: There is no recording.
    """
    decoder, found = Decoder(), []
    for message in SessionReader(folder).messages((AUDIO,)):
        m = decoder.decode(message)
        samples = np.asarray(m.samples, dtype=np.int16)
        found.append(SoundBlock(m.header.stamp.to_sec(), m.first_sample, samples))
    return sorted(found, key=lambda block: block.stamp)


def find(
    phrase: NDArray[np.float32], captured: Sequence[SoundBlock], began: float, ended: float
) -> Sounded | None:
    """Find a phrase in the captured sound.

    Args:
        phrase: As it was played, 16 kHz mono. Shape (n,).
        captured: In order of time.
        began: When the player was started [s].
        ended: When it had ended [s].

    Returns:
        When it sounded; None when it is not there or the player tore it apart.
    """
    some = [s for s in captured if began - EARLY - len(s.samples) / RATE < s.stamp < ended + LATE]
    if not some:
        return None
    sound, stamps = _joined(some)
    if len(sound) < len(phrase):
        return None
    likeness = _likeness(sound, phrase)
    at = int(likeness.argmax())
    if likeness[at] < WHOLE:
        return None
    begin = float(stamps[at])
    return Sounded(begin, begin + end_of_speech(phrase), float(likeness[at]))


def _joined(some: Sequence[SoundBlock]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Samples and their capture times; what was lost is silent.

    The stamp of a block is as good as the clock that set it, so a line is put through all.
    """
    first = some[0].first
    length = some[-1].first + len(some[-1].samples) - first
    sound = np.zeros(length)
    for block in some:
        at = block.first - first
        sound[at : at + len(block.samples)] = block.samples
    zero = float(np.median([b.stamp - (b.first - first) / RATE for b in some]))
    return sound, zero + np.arange(length) / RATE


def _likeness(sound: NDArray[np.float64], phrase: NDArray[np.float32]) -> NDArray[np.float64]:
    """Correlation coefficient of a phrase with every stretch of a sound."""
    known = phrase.astype(np.float64) - phrase.mean()
    products = correlate(sound, known, mode="valid", method="fft")
    n = len(known)
    total, square = (np.concatenate(([0.0], np.cumsum(x))) for x in (sound, sound**2))
    variance = (square[n:] - square[:-n]) - (total[n:] - total[:-n]) ** 2 / n
    scale = np.sqrt(np.maximum(variance, 1.0) * np.sum(known**2))
    return np.asarray(products / scale, dtype=np.float64)
