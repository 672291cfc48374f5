# SPDX-License-Identifier: BSD-3-Clause
"""Checks each take at once, so that a bad one can be said again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from voice_assist.audio.capture.input_check import FULL
from voice_assist.audio.mixing import BLOCK
from voice_assist.audio.source import level_db
from voice_assist.config.enrolment import CheckConfig
from voice_assist.intent.mapper import Mapper
from voice_assist.profile.loudness import level_and_snr, speech_of, spoken_blocks
from voice_assist.profile.manifest import ROOM, TALK
from voice_assist.types import RATE, Match, Samples

if TYPE_CHECKING:
    from voice_assist.config import CommandsConfig
    from voice_assist.recognizer.recognizer import Recognizer

_AROUND = 0.25  # [s] of sound in front of and behind the speech that recognition hears


@dataclass(frozen=True)
class Checked:
    """What a take is like, and what is wrong with it."""

    seconds: float  # [s] of speech
    level_db: float  # [dB] of full scale, of the speech
    snr_db: float  # [dB] of the speech over the quiet around it
    heard: str  # by the base model; empty for talk and room
    problems: tuple[str, ...] = ()  # each names value and limit; empty: it is good
    is_other: bool = False  # another command was said
    is_unlike: bool = False  # the only problem: the base hardly finds the command in it

    @property
    def is_good(self) -> bool:
        """Nothing is wrong with it."""
        return not self.problems


class TakeCheck:
    """Checks takes against the limits and, for commands, against the base recogniser."""

    def __init__(
        self, config: CheckConfig, commands: CommandsConfig, recognizer: Recognizer
    ) -> None:
        """Judge by these limits, and by what this recogniser hears."""
        self._config, self._commands, self._recognizer = config, commands, recognizer
        self._mapper = Mapper(commands)

    def __call__(self, kind: str, phrase: str, samples: Samples) -> Checked:
        """Check a take.

        Args:
            kind: COMMAND, TALK or ROOM.
            phrase: That should have been said, for COMMAND.
            samples: float32 in [-1, 1], 16 kHz. Shape (n,).
        """
        is_speech = spoken_blocks(samples)
        level, snr = level_and_snr(samples)
        seconds = float(is_speech.sum()) * BLOCK / RATE
        if kind == ROOM:
            clipped = self._clipped(samples)
            return Checked(seconds, level_db(samples), 0.0, "", clipped)
        problems = (*self._clipped(samples), *self._level(level, snr))
        if kind == TALK:
            problems += self._talk(seconds, len(samples) / RATE)
            return Checked(seconds, level, snr, "", problems)
        problems += self._length(_extent(is_speech))
        if is_speech.any():
            problems += self._edges(is_speech)
        if problems:
            return Checked(seconds, level, snr, "", problems)
        return self._words(phrase, speech_of(samples, _AROUND), Checked(seconds, level, snr, ""))

    def _clipped(self, samples: Samples) -> tuple[str, ...]:
        loud = np.abs(samples) >= 0.1 * max(float(np.abs(samples).max(initial=0.0)), 1e-9)
        share = float((np.abs(samples) >= FULL).sum()) / max(int(loud.sum()), 1)
        allowed = self._config.max_clipped
        if share <= allowed:
            return ()
        return (f"clipped: {share:.1%} of the sound at full scale, allowed: up to {allowed:.1%}",)

    def _level(self, level: float, snr: float) -> tuple[str, ...]:
        min_level, min_snr = self._config.min_level, self._config.min_snr
        if level < min_level:
            return (f"too quiet: {level:.0f} dB of full scale, allowed: at least {min_level:.0f}",)
        if snr < min_snr:
            return (f"too noisy: {snr:.0f} dB over the room, allowed: at least {min_snr:.0f}",)
        return ()

    def _talk(self, seconds: float, whole: float) -> tuple[str, ...]:
        share, min_talk = seconds / max(whole, 1e-9), self._config.min_talk
        if share >= min_talk:
            return ()
        return (f"too little talk: {share:.0%} of the time, allowed: at least {min_talk:.0%}",)

    def _length(self, seconds: float) -> tuple[str, ...]:
        low, high = self._config.min_length, self._config.max_length
        if seconds < low:
            return (f"too short: {seconds:.2f} s of speech, allowed: at least {low:.2f}",)
        if seconds > high:
            return (f"too long: {seconds:.2f} s of speech, allowed: up to {high:.2f}",)
        return ()

    def _edges(self, is_speech: np.ndarray) -> tuple[str, ...]:
        found = np.flatnonzero(is_speech)
        before = float(found[0]) * BLOCK / RATE
        after = float(len(is_speech) - 1 - found[-1]) * BLOCK / RATE
        edge, problems = self._config.edge, []
        if before < edge:
            problems.append(f"cut at the start: {before:.2f} s before it, allowed: {edge:.2f}")
        if after < edge:
            problems.append(f"cut at the end: {after:.2f} s after it, allowed: {edge:.2f}")
        return tuple(problems)

    def _words(self, phrase: str, speech: Samples, good: Checked) -> Checked:
        """Compare what the base hears with what should have been said."""
        heard = self._recognizer.transcribe(speech).text
        facts = good.seconds, good.level_db, good.snr_db, heard
        outcome = self._mapper(heard)
        command = outcome.command if isinstance(outcome, Match) else ""
        if command == phrase:
            return Checked(*facts)
        scores = self._recognizer.score(speech, self._commands.fixed_phrases)
        if command and scores[command] >= self._config.other_by:
            allowed = f"{phrase!r}, or nothing as clear (less than {self._config.other_by:g} nat)"
            found = f"{heard!r} was heard, by {scores[command]:.1f} nat"
            return Checked(*facts, (f"wrong word: {found}, allowed: {allowed}",), is_other=True)
        if scores[phrase] < -self._config.unlike_by:
            found = f"{heard!r} was heard, {phrase!r} is {-scores[phrase]:.0f} nat less likely"
            unlike = f"unlike: {found}, allowed: up to {self._config.unlike_by:g}"
            return Checked(*facts, (unlike,), is_unlike=True)
        return Checked(*facts)


def _extent(is_speech: np.ndarray) -> float:
    """From the first to the last speech [s]."""
    found = np.flatnonzero(is_speech)
    return float(found[-1] + 1 - found[0]) * BLOCK / RATE if len(found) else 0.0
