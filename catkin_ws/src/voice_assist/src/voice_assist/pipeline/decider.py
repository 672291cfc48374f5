# SPDX-License-Identifier: BSD-3-Clause
"""From the newest transcript of an utterance to a command, a refusal, or nothing yet.

A stop is taken in `Decider.stop`, or in `Decider.spotted` where the spotter fired alone.
Every other command is taken in `Decider.command`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from voice_assist.config import CommandConfig, VoiceConfig
from voice_assist.config.calibration import log_odds
from voice_assist.config.commands import AmountCommand
from voice_assist.intent.early_decision import DecisionContext, EarlyDecision, too_unsure
from voice_assist.intent.mapper import Mapper
from voice_assist.intent.rejection_rules import RejectionRules, another_word, to_be_confirmed
from voice_assist.text.normalize import contains, is_negated, normalize
from voice_assist.types import Hypothesis, Match, NoMatch, Rejection, RejectionReason, Samples

if TYPE_CHECKING:
    from voice_assist.pipeline.partial_decoding import PartialDecoder
    from voice_assist.spotter.fusion import StopFusion
    from voice_assist.spotter.spotter import Spotted
    from voice_assist.vad.segmenter import PartialUtterance

RECOGNIZER, SPOTTER = "recognizer", "spotter"  # who decided
NEVER = 1000.0  # [nat] a `halt_score_threshold` that switches halts by score off


class StopInSound(Protocol):
    """The spotter over talk, asked about the sound of an utterance: how surely a stop is in it.

    A sound has shape (n,), an answer is in nat.
    """

    def restart(self) -> None:
        """What follows is another sound."""

    def follow(self, sound: Samples) -> None:
        """Take the sound so far, so that little is left to do when it is asked."""

    def best(self, sound: Samples) -> float:
        """Of all of the sound so far."""
        ...

    def newest(self, sound: Samples) -> float:
        """Of its end alone."""
        ...


@dataclass(frozen=True)
class Verdict:
    """What an utterance is taken for, before the dialogue acts on it."""

    outcome: Match | NoMatch
    hypothesis: Hypothesis
    confidence: float
    decided_by: str


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
        self._stop_in_sound = stop_in_sound
        self._config, self._recognizer_config = config, config.recognizer
        self._mapper, self._decoder, self._stop_fusion = mapper, decoder, stop_fusion
        self._rejection_rules = rejection_rules
        early = config.recognizer.early
        self._early_decision = EarlyDecision(mapper, config.commands, early, stop_fusion)
        commands = config.commands.commands
        self._halts = {c.phrase: c for c in commands if c.is_halt}
        self._halted_until = float("-inf")  # [s] clock time up to which sound has led to a halt
        self._votes = 0  # transcripts in a row with a halt among their words, in motion

    def reset(self) -> None:
        """Forget the stream so far."""
        self._halted_until = float("-inf")
        self.start_utterance()

    def start_utterance(self) -> None:
        """What is said next belongs to a new utterance."""
        self._early_decision.reset()
        self._votes = 0
        self.start_sound()

    def start_sound(self) -> None:
        """The utterance goes on without its sound so far."""
        if self._stop_in_sound is not None:
            self._stop_in_sound.restart()

    def hear(self, sound: Samples) -> None:
        """Take the utterance's sound so far, shape (n,), with each frame."""
        if self._stop_in_sound is not None:
            self._stop_in_sound.follow(sound)

    def accept(self, command: CommandConfig, partial: PartialUtterance) -> None:
        """Note that a command was taken from an utterance."""
        self._early_decision.accept(command.phrase)
        if command.is_halt:
            self._votes = 0
            self._halted_until = partial.utterance.speech_end + partial.quiet

    def __call__(
        self, transcript: Hypothesis, partial: PartialUtterance, context: DecisionContext
    ) -> Verdict | None:
        """Decide about the newest transcript; None: wait for more."""
        if context.is_moving and (stop := self._stop_in_motion(transcript, partial)) is not None:
            return stop
        outcome = self._early_decision(transcript, context)
        stop = self.stop(outcome, transcript, partial, context)
        is_over_at_rest = context.is_complete and not context.is_moving
        if stop is None and is_over_at_rest and not isinstance(outcome, Match):
            stop = self._stop_over_talk(transcript, partial)
        if stop is not None:
            return stop
        if isinstance(outcome, Match):
            is_motion = self._config.commands.get(outcome.command).is_motion
            stop = self._stop_beside(transcript, partial) if is_motion else None
            return stop or self.command(outcome, transcript, partial)
        if outcome is not None:
            worth = self._recognizer_config.confidence.transcript
            return Verdict(outcome, transcript, worth(log_odds(transcript.confidence)), RECOGNIZER)
        if self._decoder.is_settled(partial):
            self._prepare(transcript, partial)
        return None

    def stop(
        self,
        outcome: Match | NoMatch | None,
        transcript: Hypothesis,
        partial: PartialUtterance,
        context: DecisionContext,
    ) -> Verdict | None:
        """A stop by the first way that holds; None: no stop.

        1. The last part of the sound says it over the robot's own voice.
        2. The transcript says it (confirmed by `StopFusion.confirms`).
        3. The spotter or the scores are sure of it, where the transcript names no command.

        The spotter alone stops by `spotted`.
        """
        worth = self._recognizer_config.confidence
        part = self._decoder.part
        least = self._config.audio.robot_speech.stop_over_speech_confidence
        over = self._early_decision.said_over(part, least)
        if over is not None and context.is_moving and not self._is_heard_over_talk(partial):
            over = None
        if part is not None and over is not None:
            return Verdict(over, part, worth.transcript(log_odds(part.confidence)), RECOGNIZER)
        confidence = worth.transcript(log_odds(transcript.confidence))
        if isinstance(outcome, Match):
            is_halt = outcome.command in self._halts
            return Verdict(outcome, transcript, confidence, RECOGNIZER) if is_halt else None
        unwritten = self._unwritten_stop(transcript, partial, context.spotted)
        if unwritten is None:
            return None
        confidence = confidence if context.spotted is None else worth.spotter(context.spotted)
        return Verdict(unwritten, transcript, confidence, SPOTTER)

    def spotted(self, spotted: Spotted) -> Verdict | None:
        """The stop that the spotter fired alone; None: the recogniser was quicker."""
        if spotted.time - self._halted_until < self._config.spotter.rearm_after:
            return None
        transcript = self._decoder.transcript or Hypothesis("", 0.0, 0.0)
        match = Match(self._stop_fusion.phrase, self._mapper(transcript.text).wer)
        confidence = self._recognizer_config.confidence.spotter(spotted.score)
        return Verdict(match, transcript, confidence, SPOTTER)

    def _stop_in_motion(self, transcript: Hypothesis, partial: PartialUtterance) -> Verdict | None:
        """A stop among the words of a transcript, while the robot moves.

        The spotter over talk must have heard it, too. Without one, enough transcripts in a row
        must hold it.
        """
        written = self._written_among(transcript)
        self._votes = self._votes + 1 if written else 0
        needed = self._config.moving.sentence_agreement if self._stop_in_sound is None else 1
        if written is None or self._votes < needed or not self._is_heard_over_talk(partial):
            return None
        phrase, heard = written
        worth = self._recognizer_config.confidence.transcript(log_odds(heard.confidence))
        return Verdict(Match(phrase, self._mapper(heard.text).wer), heard, worth, RECOGNIZER)

    def _is_heard_over_talk(self, partial: PartialUtterance) -> bool:
        """Whether the spotter over talk heard a stop in the newest sound, or there is none."""
        if self._stop_in_sound is None:
            return True
        score = self._stop_in_sound.newest(partial.utterance.samples)
        return score >= self._config.moving.over_talk_agree

    def _written_among(self, transcript: Hypothesis) -> tuple[str, Hypothesis] | None:
        """A halt that stands among other words, and the transcript; None: there is none."""
        least = self._config.moving.sentence_confidence
        for heard in (self._decoder.part, transcript):
            if heard is not None and heard.confidence >= least:
                words = self._mapper.words(heard.text)
                for phrase in self._halts:
                    if contains(words, normalize(phrase)):
                        return phrase, heard
        return None

    def _stop_over_talk(self, transcript: Hypothesis, partial: PartialUtterance) -> Verdict | None:
        """A stop under other people's talk, at the end of the whole utterance.

        Where the transcript has a halt among its words, somebody said it in a sentence: it is none.
        """
        words = self._mapper.words(transcript.text)
        written = any(contains(words, normalize(halt)) for halt in self._halts)
        if self._stop_in_sound is None or written or self._early_decision.has_halted:
            return None
        score = self._stop_in_sound.best(partial.utterance.samples)
        if score < self._config.spotter.over_talk_alone:
            return None
        match = Match(self._stop_fusion.phrase, self._mapper(transcript.text).wer)
        confidence = self._recognizer_config.confidence.spotter(score)
        return Verdict(match, transcript, confidence, SPOTTER)

    def _stop_beside(self, transcript: Hypothesis, partial: PartialUtterance) -> Verdict | None:
        """What is said at the same time as a motion: a stop, or a reason to refuse the motion.

        The motion would begin now, so the operating point of a moving robot counts for its sound.
        """
        moving = self._config.moving
        if not moving.is_enabled:
            return None
        spotted = self._stop_fusion.best_since(partial.utterance.speech_start)
        by_spotter = NEVER if spotted is None else moving.spotter_alone - spotted
        missing = [(by_spotter, moving.spotter_alone - moving.refuse_spotter)]
        if self._stop_in_sound is not None:
            lacks = moving.over_talk_alone - self._stop_in_sound.best(partial.utterance.samples)
            missing.append((lacks, moving.over_talk_alone - moving.refuse_over_talk))
        if all(lacks > allowed for lacks, allowed in missing):
            return None
        lacks = min(lacks for lacks, _ in missing)
        phrase = self._stop_fusion.phrase
        stop = Match(phrase, self._mapper(transcript.text).wer)
        outcome: Match | NoMatch = stop
        if lacks > 0.0:
            words = f"a {phrase!r} may be in the same sound: {lacks:.1f} nat short of one"
            outcome = stop.rejected(Rejection(RejectionReason.SECOND_VOICE, words))
        worth = self._recognizer_config.confidence.spotter(moving.spotter_alone - lacks)
        return Verdict(outcome, transcript, worth, SPOTTER)

    def command(self, match: Match, transcript: Hypothesis, partial: PartialUtterance) -> Verdict:
        """A command that is no halt, or why it is not taken, by the scores of whole commands."""
        command, worth = self._config.commands.get(match.command), self._recognizer_config
        confidence = worth.confidence.transcript(log_odds(transcript.confidence))
        rejection = None
        if worth.second_opinion:
            best, score = self._best_scored(match, transcript)
            confidence = worth.confidence.scores(score)
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
        is_asking, least = ask.is_enabled and command.is_motion, config.motion_verification
        sure = max(least, ask.sure_verification) if is_asking else least
        if confidence < command.min_confidence:
            doubt = too_unsure(confidence, command.min_confidence)
        elif odds < sure:
            doubt = another_word(match.command, odds, sure)
        elif isinstance(command, AmountCommand) and command.is_large:
            return to_be_confirmed(ask, "a large amount", command.too_large)
        else:
            return None
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
        """A motion that was asked for, or why the answer is not taken."""
        command, wer = self._config.commands.get(phrase), self._mapper(answer.text).wer
        match = Match(phrase, wer)
        rejection = self._rejection_rules(command, answer, self._decoder.sound, partial)
        worth = self._recognizer_config.confidence.transcript(log_odds(answer.confidence))
        outcome = match if rejection is None else match.rejected(rejection)
        return Verdict(outcome, answer, worth, RECOGNIZER)

    def _prepare(self, transcript: Hypothesis, partial: PartialUtterance) -> None:
        """Compute in the pause what a decision at its end will need."""
        match = self._mapper(transcript.text)
        if isinstance(match, Match) and match.command not in self._halts:
            self.command(match, transcript, partial)

    def _unwritten_stop(
        self, transcript: Hypothesis, partial: PartialUtterance, spotted: float | None
    ) -> Match | None:
        """A halt that the transcript misses, but the spotter is sure of, or the scores are."""
        if self._early_decision.has_halted or is_negated(normalize(transcript.text)):
            return None
        if self._stop_fusion.is_asking(spotted):
            phrase = self._stop_fusion.phrase
            ratio = self._decoder.scores(self._config.commands.fixed_phrases)[phrase]
            if self._stop_fusion.overrules(spotted, ratio):
                return Match(phrase, self._mapper(transcript.text).wer)
        return self._scored_stop(transcript) if self._decoder.is_settled(partial) else None

    def _scored_stop(self, transcript: Hypothesis) -> Match | None:
        """A halt whose score alone is above its `halt_score_threshold`."""
        halts = [h for h in self._halts.values() if h.halt_score_threshold < NEVER]
        is_asked = halts and self._recognizer_config.second_opinion
        if not is_asked or self._early_decision.has_decided:
            return None
        scores = self._decoder.scores(self._config.commands.fixed_phrases)
        for halt in halts:
            if scores[halt.phrase] > halt.halt_score_threshold:
                return Match(halt.phrase, self._mapper(transcript.text).wer)
        return None
