# SPDX-License-Identifier: BSD-3-Clause
"""What the pipeline asks of any recogniser."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from voice_assist.types import Hypothesis, IsHopeless, Samples, never_hopeless

SHORTEST = 0.1  # [s] shorter sound is heard as nothing
NO_SPEECH_THRESHOLD = 0.6  # [0, 1] from which words count as made up; speech stays below 0.02


class Recognizer(Protocol):
    """Turns a stretch of sound into text, and weighs given texts against it."""

    name: str  # as asked for: "embedded", a Whisper model or a file
    model_hash: str  # SHA-256 of the checkpoint file, hexadecimal

    def transcribe(self, samples: Samples, is_hopeless: IsHopeless = never_hopeless) -> Hypothesis:
        """Text of the sound, empty when nothing was said.

        Args:
            samples: float32 in [-1, 1], 16 kHz mono; the last `types.LONGEST` of it is heard.
                Shape (n,).
            is_hopeless: May be asked of beginnings of the text, each as it will stand. After a yes
                the rest may be written roughly, which is quicker.
        """
        ...

    def score(self, samples: Samples, phrases: Sequence[str]) -> dict[str, float]:
        """Second opinion on phrases: does the sound say this and nothing else?

        Args:
            samples: As for transcribe.
            phrases: Normalised texts, each at least one letter.

        Returns:
            For each phrase the natural log of its likelihood over that of the best
            other text: the free transcripts, silence and the other phrases. At
            most 0 where another text explains the sound as well or better.
        """
        ...

    def verify(self, samples: Samples, phrase: str) -> float:
        """Third opinion on one phrase: is it this, or a strange word that is written the same?

        Args:
            samples: As for transcribe.
            phrase: As for score.

        Returns:
            Log-odds of the phrase [nat]; infinity from a recogniser that cannot verify it.
        """
        ...


def drop_hallucination(text: str, avg_logprob: float, no_speech_prob: float) -> Hypothesis:
    """A transcript without the words that a network makes up where there is hardly speech.

    Whisper itself applies its threshold only where the words are unsure, too.

    Args:
        text: As decoded.
        avg_logprob: Mean log-probability per token.
        no_speech_prob: That nothing was said, [0, 1].
    """
    said = text if no_speech_prob < NO_SPEECH_THRESHOLD else ""
    return Hypothesis(said, min(avg_logprob, 0.0), no_speech_prob)


def is_same(heard: Samples, samples: Samples) -> bool:
    """Whether a sound is one that was heard already, and cannot have changed since."""
    return heard is samples and not samples.flags.writeable
