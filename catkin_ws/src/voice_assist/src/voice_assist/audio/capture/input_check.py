# SPDX-License-Identifier: BSD-3-Clause
"""Finds by the sound alone that nobody could be heard: a dead microphone, or an overloaded one.

A microphone always hears something of the room. One that is muted, or broken behind its converter,
gives the same value again and again; one that is overloaded is near full scale all the time. Speech
does neither for long: even where it is too loud, its pauses are not (380 clips of people, by their
peaks: none was as loud as that for 1.5 s, and 5 when made 20 dB too loud). So what counts is how
long no single frame was of use.

A headset that is muted by its own switch still gives the noise of its converter. That noise is weak
and white. A room's falls with frequency, so that neighbouring samples correlate, in a quiet room
too. The constant offset of a cheap sound card is taken off first. In 260 clips of people, who used
all kinds of microphones, the longest stretch below `WEAKEST_DB` was 1.4 s, and the longest that was
weak and white 1.7 s. Noise with hum in it passes for a room. So does that of a headset at 8 kHz.

A recording, the monitor of a sink and what others publish may be silent for hours: they are not
watched.
"""

from __future__ import annotations

import math

import numpy as np

from voice_assist.audio.capture.microphone import Microphone
from voice_assist.audio.corruption import smoothness
from voice_assist.audio.source import AudioSource, level_db
from voice_assist.types import Frame, HearingFault, Samples

FULL = 0.999  # of full scale; a sample at or above it was clipped, or nearly
WEAKEST_DB = -90.0  # of full scale, RMS of a frame: less than one step of 16-bit sound
WEAK_DB = -60.0  # of full scale, RMS of a frame, below which it may be a converter's noise
MIN_ROOM = 0.25  # smoothness of a frame of a room; of white noise it is 0, give or take 0.04
ROOMLESS_AFTER = 4.0  # [s] without any of a room, from which it is named
LOUDEST_DB = -6.0  # of full scale, RMS of a frame, from which it is of no use


def is_constant(samples: Samples) -> bool:
    """Whether they all have one value. Shape (n,), n > 0."""
    return bool(np.all(samples == samples[0]))


def at_full_scale(samples: Samples) -> float:
    """Share of samples that are clipped [0, 1]. Shape (n,), n > 0."""
    return float(np.mean(np.abs(samples) >= FULL))


def is_roomless(samples: Samples) -> bool:
    """Whether nothing of a room is in them. Shape (n,), n > 0."""
    level = level_db(samples - samples.mean())
    return level < WEAKEST_DB or (level < WEAK_DB and smoothness(samples) < MIN_ROOM)


class SoundWatch:
    """Follows the frames of one source.

    Args:
        source: That they come from.
        patience: Without a frame of use from which on nobody would be heard [s].
    """

    def __init__(self, source: AudioSource, patience: float) -> None:
        self._source, self._patience = source, patience
        self._useless = 0.0  # [s] since the last frame of use
        self._overloaded = 0.0  # [s] of these
        self._roomless = 0.0  # [s] since the last frame with anything of a room
        self._power = 0.0  # [s] of these, each times its power
        self._words = ""
        self.fault = HearingFault.NO_SOUND  # that of the last frame

    def __call__(self, frame: Frame) -> str:
        """Why nobody would be heard, in words that stay the same until it is over; empty: fine."""
        samples = frame.samples
        is_overloaded = level_db(samples) >= LOUDEST_DB
        is_useless = self._is_watched() and (is_overloaded or is_constant(samples))
        has_room = not self._is_watched() or not (is_constant(samples) or is_roomless(samples))
        self._useless = self._useless + frame.duration if is_useless else 0.0
        self._overloaded = self._overloaded + frame.duration * is_overloaded if is_useless else 0.0
        self._roomless = 0.0 if has_room else self._roomless + frame.duration
        self._power = 0.0 if has_room else self._power + frame.duration * _power(samples)
        is_deaf = self._useless >= self._patience or self._roomless >= ROOMLESS_AFTER
        self._words = (self._words or self._explained()) if is_deaf else ""
        return self._words

    def _is_watched(self) -> bool:
        return isinstance(self._source, Microphone) and not self._source.is_monitor

    def _explained(self) -> str:
        if self._useless < self._patience:
            self.fault = HearingFault.MUTED
            level = 10.0 * math.log10(max(self._power / self._roomless, 1e-12))
            weak = f"{level:.0f} dB of full scale and nothing of a room"
            span = f"for {self._roomless:.1f} s, allowed below {ROOMLESS_AFTER:g} s"
            return f"the microphone gives {weak} {span}: it is muted, or dead"
        span = f"for {self._useless:.1f} s, allowed below {self._patience:g} s"
        if 2.0 * self._overloaded > self._useless:
            self.fault = HearingFault.OVERLOADED
            return f"the microphone is overloaded {span}: too loud here, or its gain is too high"
        self.fault = HearingFault.MUTED
        return f"the microphone gives one value alone {span}: it is muted, or dead"


def _power(samples: Samples) -> float:
    return float(np.var(samples, dtype=np.float64))
