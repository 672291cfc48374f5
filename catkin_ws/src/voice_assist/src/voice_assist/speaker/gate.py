# SPDX-License-Identifier: BSD-3-Clause
"""Lets a motion command pass in the enrolled voice only. It is never asked about a stop.

A gate that cannot judge refuses. Each utterance is judged by itself: pooled with earlier ones it
would be surer of the surgeon, and would let the person who speaks next pass as well.
"""

from __future__ import annotations

from typing import Protocol

from voice_assist.config.speaker import SpeakerConfig
from voice_assist.errors import VoiceError
from voice_assist.speaker.cohort import Cohort, read_cohort
from voice_assist.speaker.network import VoiceNetwork
from voice_assist.speaker.speech import spoken
from voice_assist.speaker.voiceprint import Embed, Voiceprint, VoiceprintError
from voice_assist.types import RATE, Rejection, RejectionReason, Samples


class Gate(Protocol):
    """Gives why a motion command is not taken."""

    def __call__(self, samples: Samples) -> Rejection | None:
        """Why a sound, shape (n,), may move nothing; None: it may."""
        ...


class ClosedGate:
    """Refuses every motion, since the speaker cannot be identified."""

    def __init__(self, why: str) -> None:
        """Keep the reason."""
        self._why = why

    def __call__(self, samples: Samples) -> Rejection | None:
        """Why nothing moves."""
        return _other_voice(f"the speaker gate is on, and cannot judge: {self._why}")


class SpeakerGate:
    """Compares the voice with that of a profile.

    Args:
        voiceprint: Of the profile.
        embed: The network.
        cohort: Background voices.
        config: How much speech it takes.
    """

    def __init__(
        self, voiceprint: Voiceprint, embed: Embed, cohort: Cohort, config: SpeakerConfig
    ) -> None:
        self._voiceprint, self._embed, self._cohort = voiceprint, embed, cohort
        self._min_speech = config.min_speech
        self._last: tuple[Samples, Rejection | None] | None = None  # the sound judged last, and how

    def __call__(self, samples: Samples) -> Rejection | None:
        """Why a sound may move nothing; the same sound is judged once."""
        if self._last is None or self._last[0] is not samples:
            self._last = samples, self._judge(samples)
        return self._last[1]

    def _judge(self, samples: Samples) -> Rejection | None:
        speech = spoken(samples)
        if (seconds := len(speech) / RATE) < self._min_speech:
            allowed = f"allowed: at least {self._min_speech:g} s"
            return _other_voice(f"{seconds:.2f} s of speech is too short to judge it, {allowed}")
        try:
            score = float(self._cohort.score(self._embed(speech), self._voiceprint.centre))
        except (RuntimeError, ValueError) as error:
            return _other_voice(f"the speaker gate failed: {error!r}"[:200])
        if score >= self._voiceprint.threshold:  # no number is below it, too
            return None
        allowed = f"allowed: at least {self._voiceprint.threshold:.1f}"
        return _other_voice(f"not this voice: score {score:.1f}, {allowed}")


def _other_voice(words: str) -> Rejection:
    return Rejection(RejectionReason.OTHER_VOICE, words)


def make_gate(config: SpeakerConfig, voiceprint: bytes | None) -> Gate | None:
    """The gate that the settings ask for; None: none. It never raises, it stays closed.

    Args:
        config: Whether there is one.
        voiceprint: File FILE of the profile in use; None: no profile, or one without.
    """
    if not config.is_on:
        return None
    if voiceprint is None:
        return ClosedGate("no profile with a voiceprint is in use; enrol, or set speaker.gate: off")
    try:
        known = Voiceprint.from_bytes(voiceprint)
        cohort, digest = read_cohort()
        if known.cohort != digest:
            raise VoiceprintError("it was made with other background voices; make it again")
        return SpeakerGate(known, VoiceNetwork(), cohort, config)
    except VoiceError as error:
        return ClosedGate(str(error))
