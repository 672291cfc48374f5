# SPDX-License-Identifier: BSD-3-Clause
"""When a stop is taken, by any of the ways to one: each is a method of `StopDecider`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from voice_assist.config import VoiceConfig
from voice_assist.config.calibration import log_odds
from voice_assist.intent.early_decision import DecisionContext, EarlyDecision
from voice_assist.intent.mapper import Mapper
from voice_assist.pipeline.partial_decoding import PartialDecoder
from voice_assist.text.normalize import contains, is_negated, normalize
from voice_assist.types import Hypothesis, Match, NoMatch, Rejection, RejectionReason, Samples

if TYPE_CHECKING:
    from voice_assist.spotter.fusion import StopFusion
    from voice_assist.spotter.spotter import Spotted
    from voice_assist.vad.segmenter import PartialUtterance

RECOGNIZER, SPOTTER = "recognizer", "spotter"  # who decided


class StopInSound(Protocol):
    """The spotter over talk, asked about the sound of an utterance: how surely a stop is in it.

    A sound has shape (n,), an answer is in nat.
    """

    def restart(self) -> None:
        """What follows is another sound."""

    def follow(self, sound: Samples) -> None:
        """Take the sound so far, so that little is left to do when it is asked."""

    def best(self, sound: Samples, quiet: float) -> float:
        """Of all of the sound so far, at whose end nothing was said for `quiet` [s]."""
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


class StopDecider:
    """Decides whether an utterance is a stop, and by which way."""

    def __init__(
        self,
        config: VoiceConfig,
        mapper: Mapper,
        decoder: PartialDecoder,
        stop_fusion: StopFusion,
        early_decision: EarlyDecision,
        stop_in_sound: StopInSound | None = None,
    ) -> None:
        """Join the ways.

        Args:
            config: Of all stages.
            mapper: Transcript to command.
            decoder: Holds the newest transcript, and scores phrases in its sound.
            stop_fusion: Joins recogniser and spotter.
            early_decision: What was decided of the utterance before.
            stop_in_sound: The spotter over talk; None: there is none.
        """
        self._config, self._recognizer_config = config, config.recognizer
        self._mapper, self._decoder, self._stop_fusion = mapper, decoder, stop_fusion
        self._early_decision, self._stop_in_sound = early_decision, stop_in_sound
        self.halts = tuple(c.phrase for c in config.commands.commands if c.is_halt)
        self._halted_until = float("-inf")  # [s] clock time up to which sound has led to a halt
        self._votes = 0  # transcripts in a row with a halt among their words, in motion
        self._counted: Hypothesis | None = None  # the newest of them

    def reset(self) -> None:
        """Forget the stream so far."""
        self._halted_until = float("-inf")

    def start_utterance(self) -> None:
        """What is said next belongs to a new utterance."""
        self._votes, self._counted = 0, None
        self.start_sound()

    def start_sound(self) -> None:
        """The utterance goes on without its sound so far."""
        if self._stop_in_sound is not None:
            self._stop_in_sound.restart()

    def hear(self, sound: Samples) -> None:
        """Take the utterance's sound so far, shape (n,), with each frame."""
        if self._stop_in_sound is not None:
            self._stop_in_sound.follow(sound)

    def accept(self, partial: PartialUtterance) -> None:
        """Note that a stop was taken from an utterance."""
        self._votes = 0
        self._halted_until = partial.utterance.speech_end + partial.quiet

    def in_motion(self, transcript: Hypothesis, partial: PartialUtterance) -> Verdict | None:
        """A stop among the words of a transcript, or nearly its only word, while the robot moves.

        The spotter over talk must have heard it, too. Without one, or of a halt that it does not
        know, enough transcripts in a row must hold it, or the last one: after the pause there is
        no other, and the word may have been the last.
        """
        found = self._written_among(transcript) or self._nearly_said(transcript, partial)
        if transcript is not self._counted:  # asked about again, it has no second vote
            self._counted = transcript
            self._votes = self._votes + 1 if found else 0
        if found is None:
            return None
        if self._stop_in_sound is None or found[0].command != self._stop_fusion.phrase:
            is_last = self._decoder.has_paused(partial)
            is_sure = is_last or self._votes >= self._config.moving.sentence_agreement
        else:
            score = self._stop_in_sound.newest(partial.utterance.samples)
            is_sure = score >= self._config.moving.over_talk_agree
        return Verdict(*found, RECOGNIZER) if is_sure else None

    def stop(
        self,
        outcome: Match | NoMatch | None,
        transcript: Hypothesis,
        partial: PartialUtterance,
        context: DecisionContext,
    ) -> Verdict | None:
        """A stop by the first way that holds; None: no stop.

        1. The transcript says it (confirmed by `StopFusion.confirms`).
        2. The last part of the sound says it, over the robot's own voice or in motion. While the
           robot moves silently and a spotter over talk listens, `in_motion` asks both.
        3. The spotter is sure of it, where the transcript names no command.

        The spotter alone stops by `spotted`.
        """
        worth = self._recognizer_config.confidence
        confidence = worth.transcript(log_odds(transcript.confidence))
        if isinstance(outcome, Match) and outcome.command in self.halts:
            return Verdict(outcome, transcript, confidence, RECOGNIZER)
        part = self._decoder.part
        minimum = self._config.audio.robot_speech.stop_over_speech_confidence
        is_motion_alone = context.is_moving and not context.is_robot_speaking
        is_asked_later = is_motion_alone and self._stop_in_sound is not None
        over = None if is_asked_later else self._early_decision.said_over(part, minimum)
        if part is not None and over is not None:
            return Verdict(over, part, worth.transcript(log_odds(part.confidence)), RECOGNIZER)
        has_command = isinstance(outcome, Match) or self._early_decision.has_halted
        if has_command or is_negated(normalize(transcript.text)):
            return None
        return self._overruled(transcript, context.spotted)

    def spotted(self, spotted: Spotted) -> Verdict | None:
        """The stop that the spotter fired alone; None: the recogniser was quicker."""
        since = abs(spotted.time - self._halted_until)  # also after the clock was set back
        if since < self._config.spotter.rearm_after:
            return None
        transcript = self._decoder.transcript or Hypothesis("", 0.0, 0.0)
        match = Match(self._stop_fusion.phrase, self._mapper(transcript.text).wer)
        confidence = self._recognizer_config.confidence.spotter(spotted.score)
        return Verdict(match, transcript, confidence, SPOTTER)

    def over_talk(self, transcript: Hypothesis, partial: PartialUtterance) -> Verdict | None:
        """A stop under other people's talk, at the end of the whole utterance.

        Where the transcript has a halt among its words, somebody said it in a sentence: it is none.
        """
        words = self._mapper.words(transcript.text)
        written = any(contains(words, normalize(halt)) for halt in self.halts)
        if self._stop_in_sound is None or written or self._early_decision.has_halted:
            return None
        score = self._stop_in_sound.best(partial.utterance.samples, partial.quiet)
        if score < self._config.spotter.over_talk_alone:
            return None
        match = Match(self._stop_fusion.phrase, self._mapper(transcript.text).wer)
        confidence = self._recognizer_config.confidence.spotter(score)
        return Verdict(match, transcript, confidence, SPOTTER)

    def beside(self, transcript: Hypothesis, partial: PartialUtterance) -> Verdict | None:
        """What is said at the same time as a motion: a stop, or a reason to refuse the motion.

        The motion would begin now, so the operating point of a moving robot counts for its sound.
        """
        moving = self._config.moving
        if not moving.is_enabled:
            return None
        spotted = self._stop_fusion.best_since(partial.utterance.speech_start)
        by_spotter = float("inf") if spotted is None else moving.spotter_alone - spotted
        missing = [(by_spotter, moving.spotter_alone - moving.refuse_spotter)]
        if self._stop_in_sound is not None:
            score = self._stop_in_sound.best(partial.utterance.samples, partial.quiet)
            allowed = moving.over_talk_alone - moving.refuse_over_talk
            missing.append((moving.over_talk_alone - score, allowed))
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

    def _written_among(self, transcript: Hypothesis) -> tuple[Match, Hypothesis, float] | None:
        """A halt among other words, the transcript and the confidence; None: there is none."""
        minimum = self._config.moving.sentence_confidence
        for heard in (self._decoder.part, transcript):
            if heard is not None and heard.confidence >= minimum:
                words = self._mapper.words(heard.text)
                for phrase in self.halts:
                    if contains(words, normalize(phrase)):
                        worth = self._recognizer_config.confidence.transcript
                        match = Match(phrase, self._mapper(heard.text).wer)
                        return match, heard, worth(log_odds(heard.confidence))
        return None

    def _overruled(self, transcript: Hypothesis, spotted: float | None) -> Verdict | None:
        """A stop that the transcript misses, but that the spotter is sure of."""
        if spotted is None or not self._stop_fusion.is_asking(spotted):
            return None
        phrase = self._stop_fusion.phrase
        ratio = self._decoder.scores(self._config.commands.fixed_phrases)[phrase]
        if not self._stop_fusion.overrules(spotted, ratio):
            return None
        match = Match(phrase, self._mapper(transcript.text).wer)
        worth = self._recognizer_config.confidence.spotter(spotted)
        return Verdict(match, transcript, worth, SPOTTER)

    def _nearly_said(
        self, transcript: Hypothesis, partial: PartialUtterance
    ) -> tuple[Match, Hypothesis, float] | None:
        """A halt that is little less likely than what was written instead, and as above.

        Noise makes "stuff" of a "stop". In a sentence such a word is none, so no more words than
        the halt's may be written. It may be a correction in the same breath as a motion, or what is
        left of talk that was cut. Other languages have no such score.
        """
        has_score = self._recognizer_config.second_opinion and not self._config.is_multilingual
        if not (has_score and self._decoder.is_settled(partial)):
            return None
        if self._early_decision.has_halted or is_negated(normalize(transcript.text)):
            return None
        named = self._mapper(transcript.text)
        if isinstance(named, Match) and named.command not in self.halts:
            return None
        count = len(self._mapper.words(transcript.text))
        halts = [p for p in self.halts if 1 <= count <= len(normalize(p))]
        if not halts:
            return None
        scores = self._decoder.scores(self._config.commands.fixed_phrases)
        phrase = max(halts, key=scores.__getitem__)
        if scores[phrase] < -self._config.moving.nearly_said:
            return None
        worth = self._recognizer_config.confidence.scores(scores[phrase])
        return Match(phrase, named.wer), transcript, worth
