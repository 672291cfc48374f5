# SPDX-License-Identifier: BSD-3-Clause
"""From the newest transcript of an utterance to a command, a refusal, or nothing yet.

A stop is taken in `StopDecider.stop`, or in `StopDecider.spotted` where the spotter fired alone.
Every other command is taken in `Decider.command`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from voice_assist.config import CommandConfig, VoiceConfig
from voice_assist.config.calibration import log_odds
from voice_assist.config.commands import AmountCommand
from voice_assist.intent.early_decision import DecisionContext, EarlyDecision, too_unsure
from voice_assist.intent.mapper import Mapper
from voice_assist.intent.rejection_rules import (
    RejectionRules,
    another_word,
    to_be_confirmed,
    to_be_said_again,
)
from voice_assist.pipeline.stop_decider import RECOGNIZER, StopDecider, StopInSound, Verdict
from voice_assist.types import Hypothesis, Match, NoMatch, Rejection, RejectionReason

if TYPE_CHECKING:
    from voice_assist.pipeline.partial_decoding import PartialDecoder
    from voice_assist.spotter.fusion import StopFusion
    from voice_assist.vad.segmenter import PartialUtterance


class Decider:
    """Decides about the transcripts of one utterance after the other."""

    def __init__(
        self,
        config: VoiceConfig,
        mapper: Mapper,
        decoder: PartialDecoder,
        stop_fusion: StopFusion,
        rejection_rules: RejectionRules,
        stop_in_sound: StopInSound | None = None,
    ) -> None:
        """Join the rules.

        Args:
            config: Of all stages.
            mapper: Transcript to command.
            decoder: Holds the newest transcript, and scores phrases in its sound.
            stop_fusion: Joins recogniser and spotter.
            rejection_rules: What keeps a motion from being taken.
            stop_in_sound: The spotter over talk; None: there is none.
        """
        self._config, self._recognizer_config = config, config.recognizer
        self._mapper, self._decoder = mapper, decoder
        self._rejection_rules = rejection_rules
        self._is_asking = config.is_asking
        early = config.recognizer.early
        self._early_decision = EarlyDecision(mapper, config.commands, early, stop_fusion)
        stop_rules = stop_fusion, self._early_decision, stop_in_sound
        self.stops = StopDecider(config, mapper, decoder, *stop_rules)

    def reset(self) -> None:
        """Forget the stream so far."""
        self.stops.reset()
        self.start_utterance()

    def start_utterance(self) -> None:
        """What is said next belongs to a new utterance."""
        self._early_decision.reset()
        self.stops.start_utterance()

    def accept(self, command: CommandConfig, partial: PartialUtterance) -> None:
        """Note that a command was taken from an utterance."""
        self._early_decision.accept(command.phrase)
        if command.is_halt:
            self.stops.accept(partial)

    def __call__(
        self, transcript: Hypothesis, partial: PartialUtterance, context: DecisionContext
    ) -> Verdict | None:
        """Decide about the newest transcript; None: wait for more.

        In motion, too, a stop that stands alone comes first: it waits for no second network.
        """
        outcome = self._early_decision(transcript, context)
        stop = self.stops.stop(outcome, transcript, partial, context)
        if stop is None and context.is_moving:
            stop = self.stops.in_motion(transcript, partial)
        is_over_at_rest = context.is_complete and not context.is_moving
        if stop is None and is_over_at_rest and not isinstance(outcome, Match):
            stop = self.stops.over_talk(transcript, partial)
        if stop is not None:
            return stop
        if isinstance(outcome, Match):
            return self._taken_for(outcome, transcript, partial)
        if outcome is not None:
            asked = self._asked_for(outcome, transcript, partial, context)
            if asked is not None:
                return asked
            worth = self._recognizer_config.confidence.transcript
            return Verdict(outcome, transcript, worth(log_odds(transcript.confidence)), RECOGNIZER)
        if self._decoder.is_settled(partial):
            self._prepare(transcript, partial)
        return None

    def _taken_for(
        self, match: Match, transcript: Hypothesis, partial: PartialUtterance
    ) -> Verdict:
        """A command, or the stop that is said at the same time as a motion."""
        is_motion = self._config.commands.get(match.command).is_motion
        stop = self.stops.beside(transcript, partial) if is_motion else None
        return stop or self.command(match, transcript, partial)

    def command(self, match: Match, transcript: Hypothesis, partial: PartialUtterance) -> Verdict:
        """A command that is no halt, or why it is not taken, by the scores of whole commands."""
        command, config = self._config.commands.get(match.command), self._recognizer_config
        confidence = config.confidence.transcript(log_odds(transcript.confidence))
        rejection = None
        if config.second_opinion:
            best, score = self._best_scored(match, transcript)
            confidence = config.confidence.scores(score)
            if best != match.command:
                words = f"it sounds more like {best!r}"
                rejection = Rejection(RejectionReason.SOUNDS_LIKE_ANOTHER, words)
        if rejection is None:
            rejection = self._doubt(match, confidence, transcript)
        if rejection is None or rejection.reason is RejectionReason.NEARLY_SURE:
            rules = self._rejection_rules(command, transcript, self._decoder.sound, partial)
            rejection = rules or rejection
        outcome = match if rejection is None else match.rejected(rejection)
        return Verdict(outcome, transcript, confidence, RECOGNIZER)

    def _asked_for(
        self,
        outcome: NoMatch,
        transcript: Hypothesis,
        partial: PartialUtterance,
        context: DecisionContext,
    ) -> Verdict | None:
        """A motion that is asked for, since a whole utterance sounds almost like it; None: none is.

        An accent's "tense" may be written "dense".
        """
        ask = self._recognizer_config.ask
        is_one = context.is_complete and context.is_whole and not self._early_decision.has_decided
        may_ask = self._is_asking and context.is_active and is_one
        match = self._mapper.almost(transcript.text, ask.max_distance) if may_ask else None
        if match is None or not self._config.commands.get(match.command).is_motion:
            return None
        verdict = self._taken_for(match, transcript, partial)
        if verdict.outcome == match:
            doubt = to_be_confirmed(ask, "nearly sure", outcome.rejection.words)
            return replace(verdict, outcome=match.rejected(doubt))
        is_refused = isinstance(verdict.outcome, NoMatch) and (
            verdict.outcome.rejection.reason is not RejectionReason.NEARLY_SURE
        )
        return None if is_refused else verdict

    def _best_scored(self, match: Match, transcript: Hypothesis) -> tuple[str, float]:
        """The command that the sound is most like, and the score [nat] of the one taken."""
        texts = self._texts(match, transcript)
        by_text = self._decoder.scores(tuple(texts.values()))
        scores = {phrase: by_text[text] for phrase, text in texts.items()}
        return max(scores, key=scores.__getitem__), scores[match.command]

    def _doubt(self, match: Match, confidence: float, transcript: Hypothesis) -> Rejection | None:
        """Why a command may be none, or must be asked for; None: it is one."""
        command, config = self._config.commands.get(match.command), self._recognizer_config
        ask, odds = config.ask, self._verified(match, transcript)
        if confidence < command.min_confidence:
            doubt = too_unsure(confidence, command.min_confidence)
        elif odds < config.motion_verification:
            doubt = another_word(match.command, odds, config.motion_verification)
        elif isinstance(command, AmountCommand) and command.is_large:
            return to_be_confirmed(ask, "a large amount", command.too_large)
        elif command.is_motion and self._config.commands.said_twice:
            return to_be_said_again(ask)
        else:
            return None
        is_asking = self._is_asking and command.is_motion
        least = min(ask.min_verification, config.motion_verification)
        if not is_asking or confidence < ask.min_confidence or odds < least:
            return doubt
        return to_be_confirmed(ask, "nearly sure", doubt.words)

    def _texts(self, match: Match, transcript: Hypothesis) -> dict[str, str]:
        """Per command the text by which it is scored against the sound."""
        return self._config.commands.scored(match.command, self._mapper.written(transcript.text))

    def _verified(self, match: Match, transcript: Hypothesis) -> float:
        """Log-odds [nat] that a motion is no other word that is written the same.

        The words of another language are written as the nearest English that training knew.
        """
        commands = self._config.commands
        if not (self._recognizer_config.second_opinion and commands.get(match.command).is_motion):
            return float("inf")
        return self._decoder.verify(self._texts(match, transcript)[match.command])

    def confirmed(self, phrase: str, answer: Hypothesis, partial: PartialUtterance) -> Verdict:
        """A motion that was asked for, a stop beside the answer, or why the answer is not taken."""
        stop = self.stops.beside(answer, partial)
        if stop is not None:
            return stop
        command, wer = self._config.commands.get(phrase), self._mapper(answer.text).wer
        match = Match(phrase, wer)
        rejection = self._rejection_rules(command, answer, self._decoder.sound, partial)
        worth = self._recognizer_config.confidence.transcript(log_odds(answer.confidence))
        outcome = match if rejection is None else match.rejected(rejection)
        return Verdict(outcome, answer, worth, RECOGNIZER)

    def _prepare(self, transcript: Hypothesis, partial: PartialUtterance) -> None:
        """Compute in the pause what a decision at its end will need."""
        match = self._mapper(transcript.text)
        if isinstance(match, Match) and match.command not in self.stops.halts:
            self._taken_for(match, transcript, partial)
