# SPDX-License-Identifier: BSD-3-Clause
"""When a transcript that still grows is decided upon, and as what; follows one utterance.

A halt fires as soon as it is surely heard. Any other command waits for a short pause, so that
"pull more is what he said" does not move, and there is one per utterance at most: what follows it
in the same breath can only halt.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from voice_assist.config import CommandsConfig, EarlyConfig
from voice_assist.intent.mapper import Mapper
from voice_assist.spotter.fusion import StopEvidence, StopFusion
from voice_assist.text.normalize import normalize
from voice_assist.types import Hypothesis, Match, NoMatch, Rejection, RejectionReason

_SLACK = 1e-6  # [s] so that sums of frame lengths reach their limits


@dataclass(frozen=True)
class DecisionContext:
    """Where in an utterance a transcript was made."""

    time: float  # [s] stream time
    has_paused: bool  # the pause is reached after which a whole command is taken
    is_complete: bool  # the end of the utterance is confirmed
    is_whole: bool  # the transcript is of the utterance from its very beginning
    spotted: float | None = None  # [nat] the spotter's best recent score; None: none listens
    is_moving: bool = False  # the robot moves, or may: a "stop" in a sentence is one
    is_robot_speaking: bool = False  # the robot's own voice sounds, or may; see RobotSpeech
    is_active: bool = False  # a motion would be done, and may be asked for


class EarlyDecision:
    """Decides about the transcripts of one utterance, oldest first."""

    def __init__(
        self, mapper: Mapper, commands: CommandsConfig, config: EarlyConfig, fusion: StopFusion
    ) -> None:
        """Start with a new utterance."""
        self._mapper, self._config, self._stop_fusion = mapper, config, fusion
        self._halts = {c.phrase: c.min_confidence for c in commands.commands if c.is_halt}
        self.reset()

    def reset(self) -> None:
        """Start with a new utterance."""
        self._decided = ""  # command taken from this utterance
        self._has_halted = False
        self._votes = 0  # transcripts in a row that say a halt
        self._words: tuple[str, ...] = ()
        self._unchanged_since = 0.0  # [s] stream time

    @property
    def has_decided(self) -> bool:
        """A command was already taken from this utterance."""
        return bool(self._decided) or self._has_halted

    @property
    def has_halted(self) -> bool:
        """A halt was already taken from this utterance."""
        return self._has_halted

    def __call__(self, heard: Hypothesis, context: DecisionContext) -> Match | NoMatch | None:
        """What a transcript is taken for now; None: wait for more."""
        outcome = self._mapper(heard.text)
        self._follow(heard, outcome, context)
        if isinstance(outcome, Match) and outcome.command in self._halts:
            return self._halt(outcome, heard, context)
        if not context.is_complete and not self._may_commit(outcome, heard, context):
            return None
        if not self._words:
            return None
        if isinstance(outcome, Match) and (self.has_decided or not context.is_whole):
            return outcome.rejected(self._continues())
        if isinstance(outcome, NoMatch) and self.has_decided:
            return replace(outcome, rejection=self._continues())
        return outcome

    def said_over(self, part: Hypothesis | None, minimum: float) -> Match | None:
        """A halt that stands alone in the last part of sound that somebody else talks in.

        Args:
            part: Transcript of that part; None: it was not decoded.
            minimum: Confidence from which it counts [0, 1].
        """
        if part is None or self._has_halted:
            return None
        outcome = self._mapper(part.text)
        if not isinstance(outcome, Match) or outcome.command not in self._halts:
            return None
        return outcome if part.confidence >= max(minimum, self._halts[outcome.command]) else None

    def accept(self, phrase: str) -> None:
        """Note that a command was taken."""
        if phrase in self._halts:
            self._has_halted = True
        else:
            self._decided = phrase
        self._votes, self._words = 0, ()

    def _follow(
        self, heard: Hypothesis, outcome: Match | NoMatch, context: DecisionContext
    ) -> None:
        is_halt = isinstance(outcome, Match) and outcome.command in self._halts
        is_vote = is_halt and heard.confidence >= self._config.vote_confidence
        self._votes = self._votes + 1 if is_vote else 0
        words = normalize(heard.text)
        if words != self._words:
            self._words, self._unchanged_since = words, context.time

    def _halt(
        self, outcome: Match, heard: Hypothesis, context: DecisionContext
    ) -> Match | NoMatch | None:
        if self._has_halted:
            return None
        config, minimum = self._config, self._halts[outcome.command]
        if heard.confidence < minimum:
            if not context.is_complete:
                return None
            return outcome.rejected(too_unsure(heard.confidence, minimum))
        is_now = config.is_enabled and (
            self._votes >= config.stop_agreement
            or heard.confidence >= config.first_stop_confidence
            or context.has_paused
        )
        is_ready = is_now or context.is_complete
        has_ended = context.has_paused or context.is_complete or self._is_still(context)
        is_last = has_ended or context.is_moving
        evidence = StopEvidence(heard.confidence, is_ready, is_last, context.spotted)
        if self._stop_fusion.confirms(evidence, outcome.command):
            return outcome
        words = "the recogniser is not sure, and the spotter did not hear it"
        unsure = Rejection(RejectionReason.HALT_UNSURE, words)
        return outcome.rejected(unsure) if context.is_complete else None

    def _may_commit(
        self, outcome: Match | NoMatch, heard: Hypothesis, context: DecisionContext
    ) -> bool:
        """Whether a whole command is taken before the end of the utterance."""
        config = self._config
        if not config.is_enabled or not isinstance(outcome, Match) or not context.is_whole:
            return False
        if self.has_decided or self._mapper.can_grow(heard.text):
            return False
        return self._is_still(context) or context.has_paused

    def _is_still(self, context: DecisionContext) -> bool:
        """Whether no word was added for so long that what goes on is noise."""
        return context.time - self._unchanged_since >= self._config.unchanged_for - _SLACK

    def _continues(self) -> Rejection:
        first = f"{self._decided!r}" if self._decided else "a longer utterance"
        if self._has_halted and not self._decided:
            first = "a stop"
        words = f"it continues {first} in the same breath; pause before the next command"
        return Rejection(RejectionReason.SAME_BREATH, words)


def too_unsure(confidence: float, minimum: float, of: str = "") -> Rejection:
    """Why a command that was heard is refused; `of` says of what the confidence is."""
    words = f"confidence {confidence:.2f}{of}, allowed: at least {minimum:.2f}"
    return Rejection(RejectionReason.UNSURE, words)
