# SPDX-License-Identifier: BSD-3-Clause
"""What a speech detector is, and the one that only compares levels."""

from __future__ import annotations

import math
from typing import Protocol

from voice_assist.audio.source import level_db
from voice_assist.config import VadConfig
from voice_assist.types import Frame, Samples
from voice_assist.vad.silero import SileroDetector

_STEEPNESS = 0.5  # [1/dB] of the probability around the margin
_FALL = 0.3  # share of the way down to a quieter room that the floor goes per frame
_RISE_DB = 0.06  # [dB] per frame that the floor rises, about 2 dB/s
_MIN_FLOOR_DB = -60.0  # of full scale: a quieter room counts as this
_START_FRAMES = 5  # the first frames set the floor


class Detector(Protocol):
    """Gives the probability that a frame holds speech."""

    def __call__(self, samples: Samples) -> float:
        """Probability of speech in the next frame, shape (512,): within [0, 1]."""
        ...

    def reset(self) -> None:
        """Forget the stream so far."""
        ...


class EnergyDetector:
    """Takes for speech what is clearly louder than the room has been."""

    def __init__(self, margin_db: float) -> None:
        """Start in an unknown room.

        Args:
            margin_db: Above the room's level at which the probability is 0.5 [dB].
        """
        self._margin = margin_db
        self.reset()

    def reset(self) -> None:
        """Forget the room."""
        self._floor = 0.0
        self._frames = 0

    def __call__(self, samples: Samples) -> float:
        """Probability of speech in the next frame."""
        level = level_db(samples)
        self._frames += 1
        if self._frames <= _START_FRAMES:
            self._floor = max(min(self._floor, level), _MIN_FLOOR_DB)
        elif level < self._floor:
            self._floor = max(self._floor + _FALL * (level - self._floor), _MIN_FLOOR_DB)
        else:
            self._floor += min(_RISE_DB, level - self._floor)
        reference = self._floor + self._margin
        return 1.0 / (1.0 + math.exp(min(-_STEEPNESS * (level - reference), 60.0)))


class EitherDetector:
    """The surer of two detectors."""

    def __init__(self, first: Detector, second: Detector) -> None:
        """Join them."""
        self._both = (first, second)

    def reset(self) -> None:
        """Forget the stream so far."""
        for detector in self._both:
            detector.reset()

    def __call__(self, samples: Samples) -> float:
        """Higher probability of both."""
        return max([detector(samples) for detector in self._both])


def make_detector(config: VadConfig) -> Detector:
    """The detector that the settings name."""
    energy = EnergyDetector(config.energy_margin_db)
    if config.detector == "energy":
        return energy
    silero = SileroDetector()
    return silero if config.detector == "silero" else EitherDetector(silero, energy)


LOUD_DB = -6.0  # of full scale, RMS of a frame; speech that is not clipped stays below
QUIET_DB = -26.0  # from which it is over
LONG = 0.5  # [s] of loud frames that are too much for the detector
REST = 0.2  # [s] of quiet ones, longer than the closure of a consonant


class OverloadRecovery:
    """Finds the end of an overload, after which the detector starts anew; follows a stream."""

    def __init__(self) -> None:
        self._loud = 0.0  # [s]
        self._quiet = 0.0  # [s]

    def is_over(self, frame: Frame) -> bool:
        """Whether overload has just ended; true once."""
        level = level_db(frame.samples)
        self._loud += frame.duration if level >= LOUD_DB else 0.0
        self._quiet = self._quiet + frame.duration if level <= QUIET_DB else 0.0
        if self._quiet < REST:
            return False
        was_overloaded, self._loud = self._loud >= LONG, 0.0
        return was_overloaded
