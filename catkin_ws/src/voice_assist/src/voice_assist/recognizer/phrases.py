# SPDX-License-Identifier: BSD-3-Clause
"""Hears the few phrases of one language with a multilingual model that was never trained on them.

Such a model writes a short command wrongly more often than not, and prefers short texts. But how
likely each phrase is in the sound, relative to how likely it is in other sounds, tells them apart:
log-likelihood, less its median over sounds of other words, by their spread (a cohort norm as in
speaker verification: Auckenthaler et al. 2000). Mean and spread stand with each phrase.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, log
from typing import Final

from voice_assist.config.commands import CommandConfig, CommandsConfig
from voice_assist.recognizer.embedded import is_audible
from voice_assist.recognizer.recognizer import is_same
from voice_assist.recognizer.whisper import OpenAIRecognizer
from voice_assist.text.normalize import is_negated, normalize
from voice_assist.types import Hypothesis, IsHopeless, Samples, never_hopeless

LEAST: Final = 2.0  # [spreads] above the median that a phrase must be
LEAST_OF_MOTION: Final = 3.0  # [spreads] the same of a phrase that moves the robot
APART: Final = 0.7  # [spreads] from the best phrase of another command
BEHIND: Final = 20.0  # [nat] that a phrase of no motion may be less likely than the free text
STOP: Final = "stop"  # what every halt calls, whatever its `command` says
_SURE: Final = 1.4  # log-odds of a phrase that only just counts; one more per spread above


class PhraseRecognizer:
    """A Whisper model that is asked for each phrase before it is asked for text."""

    def __init__(self, base: OpenAIRecognizer, commands: CommandsConfig) -> None:
        """Take the phrases.

        Args:
            base: Hears the language of the commands.
            commands: What can be said, in another language than English.
        """
        self.name, self.model_hash, self._base = base.name, base.model_hash, base
        self._backgrounds = {c.phrase: c.background for c in commands.commands}
        self._called = {c.phrase: _called(c) for c in commands.commands}
        self._texts = {c.phrase: [text for _, text in c.all_spellings] for c in commands.commands}
        self._halts = {c.phrase for c in commands.commands if c.is_halt}
        self._motions = {c.phrase for c in commands.commands if c.is_motion}
        self._max_behind = dict.fromkeys(self._texts, BEHIND)
        self._max_behind |= dict.fromkeys(self._motions, commands.max_behind)
        self._normed: tuple[Samples, dict[str, float]] | None = None  # of the newest sound

    def transcribe(self, samples: Samples, is_hopeless: IsHopeless = never_hopeless) -> Hypothesis:
        """The phrase that the sound surely is, else what the model writes; see Recognizer.

        It is none where the model writes a text that denies, or one that is far likelier. A stop
        is taken without that.
        """
        if not is_audible(samples):
            return Hypothesis("", 0.0, 1.0)
        norms = self._norms(samples)
        best = max(norms, key=norms.__getitem__)
        margin = self._margin(norms, best)
        surely = Hypothesis(best, -log(1.0 + exp(-_SURE - margin)), 0.0)
        if margin >= 0.0 and best in self._halts:
            return surely
        written = self._base.transcribe(samples, is_hopeless)
        is_said = margin >= 0.0 and not is_negated(normalize(written.text))
        return surely if is_said and self._is_near(samples, best, written.text) else written

    def score(self, samples: Samples, phrases: Sequence[str]) -> dict[str, float]:
        """How far each phrase is above what it needs [spreads]; below 0 another is as likely."""
        if not is_audible(samples):
            return dict.fromkeys(phrases, float("-inf"))
        norms = self._norms(samples)
        return {phrase: self._margin(norms, phrase) for phrase in phrases}

    def verify(self, samples: Samples, phrase: str) -> float:
        """It cannot; see Recognizer."""
        return float("inf")

    def _norms(self, samples: Samples) -> dict[str, float]:
        """Per phrase its normed likelihood [spreads]."""
        if self._normed is None or not is_same(self._normed[0], samples):
            likely = self._base.likelihoods(samples, self._texts)
            found = {p: (likely[p] - middle) / s for p, (middle, s) in self._backgrounds.items()}
            self._normed = samples, found
        return self._normed[1]

    def _is_near(self, samples: Samples, phrase: str, written: str) -> bool:
        """Whether a phrase is nearly as likely as the text that was written freely."""
        texts = {"": [written], phrase: self._texts[phrase]}
        likely = self._base.likelihoods(samples, texts) if written else {"": 0.0, phrase: 0.0}
        return likely[phrase] >= likely[""] - self._max_behind[phrase]

    def _margin(self, norms: dict[str, float], phrase: str) -> float:
        """How far a phrase is above what it needs [spreads]."""
        least = LEAST_OF_MOTION if phrase in self._motions else LEAST
        command = self._called[phrase]
        others = (n for p, n in norms.items() if self._called[p] != command)
        lead = norms[phrase] - max(others, default=float("-inf"))
        return min(norms[phrase] - least, lead - APART)


def _called(command: CommandConfig) -> str:
    """What a phrase calls; one that calls nothing of the robot, as of a device, stands alone."""
    return STOP if command.is_halt else command.command or command.phrase
