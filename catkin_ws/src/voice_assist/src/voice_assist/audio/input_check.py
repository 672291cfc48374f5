# SPDX-License-Identifier: BSD-3-Clause
"""Finds by the sound alone that nobody could be heard: a dead microphone, or an overloaded one.

A microphone always hears something, if only its own noise. One that is muted, or broken behind its
converter, gives the same value again and again; one that is overloaded is near full scale all the
time. Speech does neither for long: even where it is too loud, its pauses are not (380 clips of
people, by their peaks: none was as loud as that for 1.5 s, and 5 when made 20 dB too loud). So what
counts is how long no single frame was of use. A recording, the monitor of a sink and what others
publish may be silent for hours: they are not watched.
"""

from __future__ import annotations

import numpy as np

from voice_assist.audio.microphone import Microphone
from voice_assist.audio.source import AudioSource, level_db
from voice_assist.types import Frame, HearingFault, Samples

FULL = 0.999  # of full scale; a sample at or above it was clipped, or nearly
LOUDEST_DB = -6.0  # of full scale, RMS of a frame, from which it is of no use


def is_constant(samples: Samples) -> bool:
    """Whether they all have one value. Shape (n,), n > 0."""
    return bool(np.all(samples == samples[0]))


def at_full_scale(samples: Samples) -> float:
    """Share of samples that are clipped [0, 1]. Shape (n,), n > 0."""
    return float(np.mean(np.abs(samples) >= FULL))


class SoundWatch:
    """Is shown one frame after the other.

    Args:
        source: That they come from.
        patience: Without a frame of use from which on nobody would be heard [s].
    """

    def __init__(self, source: AudioSource, patience: float) -> None:
        self._source, self._patience = source, patience
        self._useless = 0.0  # [s] since the last frame of use
        self._overloaded = 0.0  # [s] of these
        self._words = ""
        self.fault = HearingFault.NO_SOUND  # that of the last frame

    def __call__(self, frame: Frame) -> str:
        """Why nobody would be heard, in words that stay the same until it is over; empty: fine."""
        is_overloaded = level_db(frame.samples) >= LOUDEST_DB
        if not self._is_watched() or not (is_overloaded or is_constant(frame.samples)):
            self._useless, self._overloaded, self._words = 0.0, 0.0, ""
            return ""
        self._useless += frame.duration
        self._overloaded += frame.duration if is_overloaded else 0.0
        if self._useless >= self._patience and not self._words:
            self._words = self._explained()
        return self._words

    def _is_watched(self) -> bool:
        return isinstance(self._source, Microphone) and not self._source.is_monitor

    def _explained(self) -> str:
        span = f"for {self._useless:.1f} s, allowed below {self._patience:g} s"
        if 2.0 * self._overloaded > self._useless:
            self.fault = HearingFault.OVERLOADED
            return f"the microphone is overloaded {span}: too loud here, or its gain is too high"
        self.fault = HearingFault.MUTED
        return f"the microphone gives one value alone {span}: it is muted, or dead"
