# SPDX-License-Identifier: BSD-3-Clause
"""The rule by which recogniser and spotter come to a stop together.

1. The spotter alone, from `alone` on (`Spotter`, latched for `rearm_after`).
2. The recogniser alone, where its word is ready (`EarlyDecision`) with a confidence of `sure`. At
   rest it waits for the pause behind the word, since talk that goes on soon reads otherwise.
3. The recogniser ready but less sure, where the spotter gave `agree` within `agree_within`; the
   written word at once, ready or not, where the spotter gave `middle`.
4. The spotter from `middle` on, where the word is at most `near` less likely to the recogniser than
   what it wrote instead.
5. Nothing else; but where no spotter listens, the recogniser decides as if there were none.
"""

from __future__ import annotations

from dataclasses import dataclass

from voice_assist.config import SpotterConfig
from voice_assist.spotter.spotter import Spotted, Spotting
from voice_assist.types import Frame


@dataclass(frozen=True)
class StopEvidence:
    """What there is for a stop that the recogniser wrote."""

    confidence: float  # [0, 1]
    is_ready: bool  # it would stop by itself now: seen twice, sure, in a pause, or at the end
    is_last: bool  # a pause is behind it; in motion always, since nothing is waited for
    spotted: float | None  # [nat] the spotter's best score recently; None: no spotter listens


class StopFusion:
    """Joins recogniser and spotter, if there is one, by the rule above; `spotter.yaml` sets it."""

    def __init__(self, config: SpotterConfig, spotting: Spotting | None) -> None:
        """Without a spotter the recogniser is on its own."""
        self._config, self._spotting = config, spotting

    @property
    def phrase(self) -> str:
        """The command that is spotted."""
        return self._config.phrase

    def reset(self) -> None:
        """Forget the stream so far."""
        if self._spotting is not None:
            self._spotting.reset()

    def update(self, frame: Frame) -> Spotted | None:
        """Let the spotter take a frame; gives what it fires alone (1)."""
        return None if self._spotting is None else self._spotting(frame)

    def best(self, now: float) -> float | None:
        """The spotter's best recent score [nat] at a clock time [s]; None: no spotter listens."""
        return self.best_since(now - self._config.agree_within)

    def best_since(self, since: float) -> float | None:
        """The spotter's best score [nat] since a clock time [s]; None: no spotter listens."""
        return None if self._spotting is None else self._spotting.best(since)

    def confirms(self, evidence: StopEvidence, phrase: str) -> bool:
        """Whether a halt that the recogniser wrote stops now (2, 3 and 5)."""
        if evidence.spotted is None or phrase != self.phrase:
            return evidence.is_ready
        if evidence.spotted >= self._config.middle:
            return True
        is_sure = evidence.is_last and evidence.confidence >= self._config.sure
        return evidence.is_ready and (is_sure or evidence.spotted >= self._config.agree)

    def is_asking(self, spotted: float | None) -> bool:
        """Whether the spotter is sure enough to ask for the recogniser's score of the word."""
        return spotted is not None and spotted >= self._config.middle

    def overrules(self, spotted: float | None, ratio: float) -> bool:
        """Whether the word stops though the recogniser wrote something else (4).

        Args:
            spotted: The spotter's best score recently [nat].
            ratio: Log-likelihood of the word less that of the recogniser's best other text [nat].
        """
        return self.is_asking(spotted) and ratio >= -self._config.near
