# SPDX-License-Identifier: BSD-3-Clause
"""What is kept of one voice: its mean embedding, and the score from which on it counts as heard."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from io import BytesIO

import numpy as np

from voice_assist.config.speaker import SpeakerConfig
from voice_assist.errors import VoiceError
from voice_assist.speaker.cohort import Cohort
from voice_assist.speaker.network import PIECE, WIDTH, Vector, unit
from voice_assist.speaker.speech import piece_up, spoken
from voice_assist.types import RATE, Samples

FILE = "voiceprint.npz"  # in a profile
FORMAT = 1
MIN_PIECES = 4  # utterances; each is judged by the mean of the others
Embed = Callable[[Samples], Vector]


class VoiceprintError(VoiceError):
    """Of these takes no voiceprint can be made, or a file holds none."""


@dataclass(frozen=True, eq=False)
class Voiceprint:
    """One voice."""

    centre: Vector  # (WIDTH,), of length 1
    threshold: float  # [standard deviations] score from which on an utterance is this voice
    false_accept: float  # [0, 1] share of background voices above the threshold
    missed: float  # [0, 1] share of its own takes below it, each judged by the others
    takes: int  # that it was made of
    cohort: str  # SHA-256 of the background that the threshold belongs to

    def to_bytes(self) -> bytes:
        """As it lies in a profile."""
        file = BytesIO()
        numbers = np.array([FORMAT, self.threshold, self.false_accept, self.missed, self.takes])
        np.savez(file, centre=self.centre, numbers=numbers, cohort=np.array(self.cohort))
        return file.getvalue()

    @classmethod
    def from_bytes(cls, data: bytes) -> Voiceprint:
        """What `to_bytes` gave.

        Raises:
            VoiceprintError: It is none, or one of another format.
        """
        try:
            with np.load(BytesIO(data), allow_pickle=False) as file:
                centre = np.asarray(file["centre"], np.float64)
                numbers = np.asarray(file["numbers"], np.float64)
                cohort = str(file["cohort"])
        except Exception as error:  # damaged bytes make numpy and zipfile raise anything
            raise VoiceprintError(f"voiceprint cannot be read: {error}"[:300]) from error
        is_sound = centre.shape == (WIDTH,) and numbers.shape == (5,)
        if not is_sound or not np.isfinite([*centre, *numbers]).all() or numbers[0] != FORMAT:
            found = f"centre {centre.shape}, numbers {numbers.shape}"
            allowed = f"({WIDTH},) and (5,), finite, of format {FORMAT}"
            raise VoiceprintError(f"voiceprint holds {found}, allowed: {allowed}")
        _, threshold, let_in, missed, takes = numbers.tolist()
        return cls(unit(centre), threshold, let_in, missed, int(takes), cohort)


def make_voiceprint(
    takes: Sequence[Samples], embed: Embed, cohort: Cohort, digest: str, config: SpeakerConfig
) -> Voiceprint:
    """Learn a voice.

    Args:
        takes: What the person said; each shape (n,), 16 kHz. Long ones count as several.
        embed: The network.
        cohort: Background voices.
        digest: SHA-256 of their file.
        config: How strict to be.

    Raises:
        VoiceprintError: There is too little speech, or it does not single the voice out.
    """
    pieces = [p for take in takes for p in piece_up(spoken(take), PIECE) if _is_enough(p, config)]
    seconds = sum(map(len, pieces)) / RATE
    if len(pieces) < MIN_PIECES or seconds < config.min_enrolled:
        allowed = f"at least {MIN_PIECES} takes and {config.min_enrolled:g} s"
        raise VoiceprintError(f"{len(pieces)} takes with {seconds:.1f} s of speech: {allowed}")
    heard = np.stack([embed(piece) for piece in pieces])
    centre = unit(heard.mean(axis=0))
    threshold = float(np.quantile(cohort.impostors(centre), 1.0 - config.false_accept))
    rest = unit(heard.sum(axis=0) - heard)  # (n, WIDTH): the mean of all others
    own = np.array([cohort.score(h, c) for h, c in zip(heard, rest, strict=True)])
    missed = float((own < threshold).mean())
    if missed > config.max_missed:
        share = f"{missed:.0%} of its own takes, allowed: up to {config.max_missed:.0%}"
        raise VoiceprintError(f"this voiceprint would refuse {share}; record them again, nearer")
    return Voiceprint(centre, threshold, config.false_accept, missed, len(pieces), digest)


def _is_enough(piece: Samples, config: SpeakerConfig) -> bool:
    return len(piece) >= config.min_speech * RATE
