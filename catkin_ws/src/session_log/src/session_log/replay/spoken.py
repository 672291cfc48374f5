# SPDX-License-Identifier: BSD-3-Clause
"""The sound of each recorded utterance, for enrolment.

The voice part finds `spoken` by its name in a setting; neither package imports the other.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from session_log.errors import SessionLogError, SessionMissing
from session_log.mcap_file.decoder import Decoder, Undecodable
from session_log.mcap_file.reader import SessionReader
from session_log.replay.command import REPLAY_CONFIG
from session_log.replay.config import ReplayConfig
from session_log.replay.pipeline_plugin import RecordedSound
from session_log.replay.recorded_voice import RATE, RecordedDecision, read_voice, sound_of
from typed_config import load_file

AROUND = 0.4  # [s] of sound kept before and after the speech
LONGEST = 30.0  # [s] of speech: a pipeline cuts it after 28 at most; more is a clock that was set


@dataclass(frozen=True, eq=False)
class SpokenUtterance:
    """One utterance with its sound."""

    time: float  # [s] from the first message of the session to the first speech
    heard: str  # transcript
    command: str  # taken; empty: none
    samples: NDArray[np.int16]  # (n,), 16 kHz mono; what is missing is silence


def spoken(path: Path) -> list[SpokenUtterance]:
    """Every utterance of a recording whose sound is in it, in the order of its speech.

    One during which the clock was set is left out: where its sound lies is not known.

    Args:
        path: An MCAP file, or the folder of a session.

    Raises:
        SessionLogError: There is no such recording, or it cannot be read.
    """
    config = load_file(ReplayConfig, REPLAY_CONFIG)
    reader = SessionReader(path, tolerant=True)
    voice = read_voice(reader, config)
    if not voice.start:
        raise SessionMissing(reader.path, "holds no readable message")
    timed = [u for u in voice.utterances if 0.0 <= u.speech_end - u.speech_start <= LONGEST]
    cut = [_Window(one) for one in sorted(timed, key=lambda one: one.speech_start)]
    starts = [window.start for window in cut]
    ends = list(accumulate((window.end for window in cut), max))  # of each and all before it
    decoder = Decoder()
    for message in reader.messages({config.topics.audio}):
        try:
            sound = sound_of(decoder.decode(message))
        except (Undecodable, AttributeError):
            continue
        if sound.rate != RATE:
            raise SessionLogError(f"{path}: sound at {sound.rate} Hz, allowed: {RATE}")
        end = sound.stamp + len(sound.samples) / RATE
        for window in cut[bisect_left(ends, sound.stamp) : bisect_right(starts, end)]:
            window.take(sound)
    return [
        SpokenUtterance(
            max(window.utterance.speech_start - voice.start, 0.0),
            window.utterance.transcript,
            window.utterance.command,
            window.samples,
        )
        for window in cut
        if window.has_sound
    ]


class _Window:
    """The stretch of time of one utterance, filled as the sound comes by."""

    def __init__(self, utterance: RecordedDecision) -> None:
        self.utterance = utterance
        self.start = utterance.speech_start - AROUND  # [s]
        length = utterance.speech_end - utterance.speech_start + 2.0 * AROUND
        self.samples = np.zeros(max(round(length * RATE), 0), np.int16)
        self.end = self.start + len(self.samples) / RATE  # [s]
        self.has_sound = False

    def take(self, sound: RecordedSound) -> None:
        """Keep what of a block lies in it."""
        first = round((sound.stamp - self.start) * RATE)
        if first >= len(self.samples) or first + len(sound.samples) <= 0:
            return
        low, high = max(first, 0), min(first + len(sound.samples), len(self.samples))
        self.samples[low:high] = sound.samples[low - first : high - first]
        self.has_sound = True
