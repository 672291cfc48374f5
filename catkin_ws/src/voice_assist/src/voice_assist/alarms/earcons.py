# SPDX-License-Identifier: BSD-3-Clause
"""The sounds of the alarms, computed: bursts of pulses whose rhythm shows priority, melody kind.

Rhythm, pulse lengths, rise times, harmonics and the pauses between bursts follow what is usual for
medical alarms (IEC 60601-1-8, clause 6.3.3: 10, 3, and 1 or 2 pulses; fundamental 150 to 1000 Hz,
at least four harmonics from 300 to 4000 Hz). The standard's patterns informed these; no conformity
with it is claimed, nor was any assessed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from voice_assist.alarms.types import Earcon, Priority
from voice_assist.types import RATE, Samples, frozen_samples

HARMONICS: Final = 6  # of an alarm's pulse, the fundamental included, as far as below HIGHEST
HIGHEST: Final = 4000.0  # [Hz]
RISE: Final = 0.15  # of a pulse
FALL: Final = 0.35
BELOW_HIGH_DB: Final = {  # peak below that of the high priority
    Priority.HIGH: 0.0,
    Priority.MEDIUM: 3.0,
    Priority.LOW: 6.0,
    Priority.INFORMATION: 12.0,
}


@dataclass(frozen=True)
class Pattern:
    """A burst: when each pulse begins, how high it is."""

    priority: Priority
    starts: tuple[float, ...]  # [s] of each pulse
    pitches: tuple[float, ...]  # [Hz] fundamental of each pulse
    pulse: float  # [s] length of each pulse
    is_soft: bool = False  # fundamental and octave only

    @property
    def duration(self) -> float:
        """From the first pulse's begin to the last one's end [s]."""
        return self.starts[-1] + self.pulse


def _even(count: int, step: float) -> tuple[float, ...]:
    return tuple(i * step for i in range(count))


# Pitches lie above those of speech: at 196 to 370 Hz such pulses pass for speech (measured).
_F4, _A4, _C5, _D5, _FIS5, _A5, _B5 = 349.2, 440.0, 523.3, 587.3, 740.0, 880.0, 987.8
_HALF: Final = (0.0, 0.16, 0.32, 0.64, 0.80)  # three and two, as usual for high priority
_BETWEEN_HALVES: Final = 1.45  # [s] from the first half's begin to the second's
_FAULT: Final = (_C5, _FIS5, _B5)  # it rises, by a tritone first: harsh

PATTERNS: Final = {
    Earcon.FAULT_HIGH: Pattern(
        Priority.HIGH,
        _HALF + tuple(_BETWEEN_HALVES + start for start in _HALF),
        2 * (*_FAULT, _FIS5, _B5),
        0.10,
    ),
    Earcon.FAULT_MEDIUM: Pattern(Priority.MEDIUM, _even(3, 0.36), _FAULT, 0.18),
    Earcon.FAULT_LOW: Pattern(Priority.LOW, _even(2, 0.40), _FAULT[:2], 0.20),
    Earcon.STOP: Pattern(Priority.MEDIUM, _even(3, 0.36), (_C5, _A4, _F4), 0.18),  # it falls
    Earcon.REFUSAL: Pattern(Priority.LOW, _even(2, 0.28), (_A4, _A4), 0.14),
    Earcon.QUESTION: Pattern(Priority.INFORMATION, _even(2, 0.28), (_A4, _D5), 0.14),  # it rises
    Earcon.ACCEPTED: Pattern(Priority.INFORMATION, (0.0,), (_A5,), 0.07, is_soft=True),
    Earcon.ARMED: Pattern(Priority.INFORMATION, _even(2, 0.14), (_D5, _A5), 0.10, is_soft=True),
    Earcon.STANDBY: Pattern(Priority.INFORMATION, _even(2, 0.14), (_A5, _D5), 0.10, is_soft=True),
}


@lru_cache(maxsize=64)
def samples_of(earcon: Earcon, volume_db: float) -> Samples:
    """A sound, 16 kHz mono, float32 in [-1, 1], read-only. Shape (n,).

    Args:
        earcon: Which one.
        volume_db: Peak of the high priority [dB] of full scale; others lie below.
    """
    pattern = PATTERNS[earcon]
    sound = np.zeros(round(pattern.duration * RATE) + 1)
    for start, pitch in zip(pattern.starts, pattern.pitches, strict=True):
        pulse = _pulse(pitch, pattern.pulse, 2 if pattern.is_soft else HARMONICS)
        first = round(start * RATE)
        sound[first : first + len(pulse)] += pulse[: len(sound) - first]
    peak = 10.0 ** ((volume_db - BELOW_HIGH_DB[pattern.priority]) / 20.0)
    return frozen_samples((sound * (peak / np.abs(sound).max())).astype(np.float32))


def _pulse(pitch: float, length: float, harmonics: int) -> NDArray[np.float64]:
    """One pulse: harmonics that fall by 6 dB an octave, raised-cosine rise and fall."""
    time = np.arange(round(length * RATE)) / RATE
    tone = np.zeros(len(time))
    for number in range(1, harmonics + 1):
        if number * pitch < HIGHEST:
            tone += np.sin(2.0 * np.pi * number * pitch * time) / number
    rise, fall = round(RISE * len(time)), round(FALL * len(time))
    envelope = np.ones(len(time))
    envelope[:rise] = 0.5 - 0.5 * np.cos(np.pi * np.arange(rise) / rise)
    envelope[len(time) - fall :] = 0.5 + 0.5 * np.cos(np.pi * np.arange(1, fall + 1) / fall)
    return tone * envelope
