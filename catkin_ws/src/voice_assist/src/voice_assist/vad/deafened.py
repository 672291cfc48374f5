# SPDX-License-Identifier: BSD-3-Clause
"""Notices that deafening sound is over, so that the speech detector can begin anew.

Silero's network keeps a state. What it never met in training, such as the mains at full scale or
noise that is all clipped, leaves a state in which it finds no speech for seconds: a "stop" said
right after it would not even be looked at.
"""

from __future__ import annotations

from voice_assist.audio.source import level_db
from voice_assist.types import Frame

LOUD_DB = -6.0  # of full scale, RMS of a frame; speech that is not clipped stays below
QUIET_DB = -26.0  # from which it is over
LONG = 0.5  # [s] of loud frames that are too much for the detector
REST = 0.2  # [s] of quiet ones, longer than the closure of a consonant


class Deafened:
    """Is shown one frame after the other."""

    def __init__(self) -> None:
        self._loud = 0.0  # [s]
        self._quiet = 0.0  # [s]

    def is_over(self, frame: Frame) -> bool:
        """Whether deafening sound has just ended; told once."""
        level = level_db(frame.samples)
        self._loud += frame.duration if level >= LOUD_DB else 0.0
        self._quiet = self._quiet + frame.duration if level <= QUIET_DB else 0.0
        if self._quiet < REST:
            return False
        was_deafened, self._loud = self._loud >= LONG, 0.0
        return was_deafened
