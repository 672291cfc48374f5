# SPDX-License-Identifier: BSD-3-Clause
"""From frames of sound to decisions; the whole way, top to bottom."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from voice_assist.audio.denoise import Denoiser
from voice_assist.audio.robot_speech import Spoke, Talkback
from voice_assist.audio.source import GapWatch
from voice_assist.config import VoiceConfig
from voice_assist.config.calibration import log_odds
from voice_assist.intent.dialogue import AT_START, Answered, Heard, State, step
from voice_assist.intent.early_decision import Judge, Moment, too_unsure
from voice_assist.intent.mapper import Mapper
from voice_assist.intent.rejection_rules import Objections
from voice_assist.pipeline.partial_decoding import Hearing
from voice_assist.side_inputs import Circumstance, Kind, Witness, ignore
from voice_assist.spotter.fusion import SecondWay
from voice_assist.spotter.spotter import Spotted
from voice_assist.text.normalize import is_negated, normalize
from voice_assist.types import (
    RATE,
    Action,
    Decision,
    Frame,
    Halt,
    Hypothesis,
    Lost,
    Match,
    Mode,
    NoMatch,
    Partial,
    Rejection,
    RejectionReason,
    Samples,
    Utterance,
    frozen_samples,
)
from voice_assist.vad.detector import Deafened, Detector
from voice_assist.vad.endpointer import Analyzer
from voice_assist.vad.segmenter import Cutter, Growth

if TYPE_CHECKING:
    from voice_assist.recognizer.recognizer import Recognizer
    from voice_assist.speaker.gate import Gate

Event = Partial | Decision | Lost
Clock = Callable[[], float]

NEVER = 1000.0  # [nat] a `halt_score_threshold` that switches firing off
_PROGRESS = RATE  # samples between two notes of how far hearing has come
_KEPT_OF_NOISE = 0.5  # [s] before a look that heard nothing, which may begin a word
_KEPT_OF_PAUSE = 0.064  # [s] before a decision in a pause that may begin the next word


class Pipeline:
    """Hears a stream frame by frame, and decides."""

    def __init__(
        self,
        config: VoiceConfig,
        recognizer: Recognizer,
        detector: Detector,
        clock: Clock,
        second: SecondWay | None = None,
        witness: Witness = ignore,
        gate: Gate | None = None,
    ) -> None:
        """Join the stages.

        Args:
            config: Of all stages.
            recognizer: Makes text of sound.
            detector: Tells speech from quiet.
            clock: The one that stamps the frames [s].
            second: The spotter and the rule that joins it; without it the recogniser is alone.
            witness: Told of all that comes in besides sound, or is not heard for lack of time.
            gate: Tells whose voice may not move the robot; None: any voice may.
        """
        self._second = second or SecondWay(config.spotter, None)
        self._config, self._clock, self._witness = config, clock, witness
        self._next_sample = 0  # index of the sample that follows all those heard
        self._recognizer, self._detector = recognizer, detector
        self._gaps = GapWatch()
        self._denoise = Denoiser(config.audio.denoise)
        self._deafened = Deafened()
        self._analyze = Analyzer(config.audio.vad)
        self._cut = Cutter(config.audio.vad)
        self._mapper = Mapper(config.commands)
        early, loses = config.recognizer.early, self._mapper.cannot_become
        self._hear = Hearing(recognizer, early, clock, witness, loses)
        self._judge = Judge(self._mapper, config.commands, early, self._second)
        self._halted = float("-inf")  # [s] clock time up to which sound has led to a halt
        self._state = AT_START
        self._talkback = Talkback(config.audio.robot_speech)
        self._object = Objections(config, self._talkback, gate)
        self._new_utterance()

    @property
    def state(self) -> State:
        """Of the dialogue."""
        return self._state

    def set_mode(self, mode: Mode, reason: str) -> None:
        """Put the dialogue into a mode."""
        self._state = State(mode, reason)

    def answer(self, answered: Answered) -> tuple[Action, ...]:
        """Tell the dialogue what the controller replied."""
        told = answered.command, answered.is_accepted, answered.message
        self._witness(Circumstance(Kind.ANSWERED, self._next_sample, 0, *told))
        outcome = step(self._state, answered)
        self._state = outcome.state
        return outcome.actions

    def robot_spoke(self, spoke: Spoke) -> None:
        """Tell that a loudspeaker of the robot's own speaks, or ended."""
        told = Circumstance(Kind.SPEAKING, self._next_sample, is_speaking=spoke.is_speaking)
        self._witness(replace(told, time=spoke.time))
        self._talkback.tell(spoke)

    def warm_up(self, samples: Samples) -> None:
        """Let the recogniser do once what it does only once, on any sound, shape (n,)."""
        self._recognizer.transcribe(samples)
        self._recognizer.score(samples, self._config.commands.phrases)
        self.reset()

    def reset(self) -> None:
        """Forget the stream so far, and keep the mode."""
        self._gaps = GapWatch()
        self._denoise.reset()
        self._deafened = Deafened()
        self._detector.reset()
        self._analyze.reset()
        self._cut.reset()
        self._second.reset()
        self._talkback.reset()
        self._halted = float("-inf")
        self._new_utterance()

    def __call__(self, frame: Frame) -> tuple[Event, ...]:
        """Take the next frame of the stream; gives what came of it, oldest first."""
        self._next_sample = frame.first_sample + len(frame.samples)
        if frame.first_sample // _PROGRESS != self._next_sample // _PROGRESS:
            self._witness(Circumstance(Kind.HEARD, frame.first_sample))
        events = self._check_gap(frame)
        cleaned = self._denoise(frame.samples)
        if self._deafened.is_over(frame):
            self._detector.reset()
        endpoint = self._analyze(self._detector(cleaned), frame.duration)
        if self._config.audio.denoise.mode == "on":
            frame = replace(frame, samples=cleaned)
        growth = self._cut(frame, endpoint)
        if spotted := self._second.hear(frame):
            events += self._take_spotted(spotted, growth)
        if growth is None:
            return events
        time = frame.first_sample / RATE + frame.duration
        own = self._talkback.is_in(frame.stamp)
        if self._hear(growth, frame, time, self._config.audio.robot_speech.window if own else 0.0):
            events += (*self._partial(frame), *self._decide(growth, frame, time))
            self._forget_noise(growth, time)
        if growth.utterance.is_complete:
            events += (Partial("", frame.stamp),) if self._shown else ()
            self._new_utterance()
        return events

    # --- hear

    def _check_gap(self, frame: Frame) -> tuple[Event, ...]:
        lost = self._gaps(frame)
        if lost is None:
            return ()
        self._witness(Circumstance(Kind.LOST, frame.first_sample))
        self._detector.reset()
        self._analyze.reset()
        self._cut.break_at(frame.stamp)
        self._new_utterance()
        return (Lost(lost, frame.stamp),)

    def _new_utterance(self) -> None:
        self._judge.reset()
        self._hear.reset()
        self._shown = ""

    def _partial(self, frame: Frame) -> tuple[Event, ...]:
        text = self._hear.heard.text if self._hear.heard else ""
        if text == self._shown:
            return ()
        self._shown = text
        return (Partial(text, frame.stamp + frame.duration),)

    def _forget_noise(self, growth: Growth, time: float) -> None:
        """Keep long noise, which the detector takes for speech, from hiding a command in it.

        Talk in which one look heard nothing is no noise: were it forgotten, its last word would
        pass for all that was said.
        """
        length = len(growth.utterance.samples) / RATE
        wordless = min(length, time - self._hear.worded_at)
        if wordless > self._config.recognizer.early.noise_after:
            self._cut.forget(_KEPT_OF_NOISE)

    # --- decide

    def _decide(self, growth: Growth, frame: Frame, time: float) -> tuple[Event, ...]:
        utterance, heard = growth.utterance, self._hear.heard
        if heard is None:
            return ()
        is_whole = growth.is_whole and not self._hear.is_window
        spotted = self._second.best(frame.stamp + frame.duration)
        moment = Moment(time, growth.quiet, utterance.is_complete, is_whole, spotted)
        outcome = self._judge(heard, moment)
        decided_by, part = "recognizer", self._hear.part
        if part and (
            over := self._judge.said_over(part, self._config.audio.robot_speech.stop_confidence)
        ):
            outcome, heard = over, part
        if not isinstance(outcome, Match) and (fired := self._fire(growth, heard, spotted)):
            outcome, decided_by = fired, "spotter"
        if outcome is None:
            if self._hear.is_settled(growth):
                self._prepare(heard, growth)
            return ()
        worth = self._config.recognizer.confidence
        confidence = worth.transcript(log_odds(heard.confidence))
        if decided_by == "spotter" and spotted is not None:
            confidence = worth.spotter(spotted)
        elif isinstance(outcome, Match):
            outcome, confidence = self._second_opinion(outcome, heard, growth)
        return (self._conclude(outcome, heard, confidence, growth, decided_by),)

    def _prepare(self, heard: Hypothesis, growth: Growth) -> None:
        """Compute in the pause what a decision at its end will need."""
        if isinstance(match := self._mapper(heard.text), Match):
            self._second_opinion(match, heard, growth)

    def _second_opinion(
        self, match: Match, heard: Hypothesis, growth: Growth
    ) -> tuple[Match | NoMatch, float]:
        """The scores of whole commands may refuse one that is no halt; gives the confidence too."""
        command, worth = (
            self._config.commands.get(match.command),
            self._config.recognizer.confidence,
        )
        confidence = worth.transcript(log_odds(heard.confidence))
        if command.is_halt:
            return match, confidence
        if self._config.recognizer.second_opinion:
            texts = self._config.commands.scored(match.command, normalize(heard.text))
            told = self._hear.scores(tuple(texts.values()))
            scores = {phrase: told[text] for phrase, text in texts.items()}
            best, score = max(scores, key=scores.__getitem__), scores[match.command]
            confidence = worth.scores(score)
            if best != match.command:
                words = f"it sounds more like {best!r}"
                other = Rejection(RejectionReason.SOUNDS_LIKE_ANOTHER, words)
                return match.rejected(other), confidence
        if confidence < command.min_confidence:
            return match.rejected(too_unsure(confidence, command.min_confidence)), confidence
        if rejection := self._object(command, heard, self._hear.sound, growth):
            return match.rejected(rejection), confidence
        return match, confidence

    def _fire(self, growth: Growth, heard: Hypothesis, spotted: float | None) -> Match | None:
        """A halt that the transcript misses, but the scores are sure of, or the spotter is."""
        if self._judge.has_halted or is_negated(normalize(heard.text)):
            return None
        if self._second.is_asking(spotted):
            phrase = self._second.phrase
            ratio = self._hear.scores(self._config.commands.phrases)[phrase]
            if self._second.overrules(spotted, ratio):
                return Match(phrase, self._mapper(heard.text).wer)
        halts = [
            c
            for c in self._config.commands.commands
            if c.is_halt and c.halt_score_threshold < NEVER
        ]
        if not (halts and self._hear.is_settled(growth) and self._config.recognizer.second_opinion):
            return None
        if self._judge.has_decided:
            return None
        scores = self._hear.scores(self._config.commands.phrases)
        for halt in halts:
            if scores[halt.phrase] > halt.halt_score_threshold:
                return Match(halt.phrase, self._mapper(heard.text).wer)
        return None

    def _take_spotted(self, spotted: Spotted, growth: Growth | None) -> tuple[Event, ...]:
        """The spotter fired alone; nothing new where the recogniser was quicker."""
        if spotted.time - self._halted < self._config.spotter.rearm_after:
            return ()
        heard = self._hear.heard or Hypothesis("", 0.0, 0.0)
        match = Match(self._second.phrase, self._mapper(heard.text).wer)
        confidence = self._config.recognizer.confidence.spotter(spotted.score)
        silent = Utterance(frozen_samples(np.zeros(0)), spotted.time, spotted.time, False)
        begun = growth or Growth(silent, 0.0, False, 0.0)
        decision = self._conclude(match, heard, confidence, begun, "spotter")
        if growth is None:  # endpointing has noticed no speech: what is said next is new
            self._judge.reset()
        if spotted.is_sent:
            left = tuple(a for a in decision.actions if not isinstance(a, Halt))
            decision = replace(decision, actions=left)
        return (decision,)

    def _conclude(
        self,
        outcome: Match | NoMatch,
        heard: Hypothesis,
        confidence: float,
        growth: Growth,
        decided_by: str,
    ) -> Decision:
        """Let the dialogue act on it, and make ready for the rest of the utterance."""
        mode = self._state.mode
        actions: tuple[Action, ...] = ()
        if isinstance(outcome, Match):
            self._accept(outcome.command, growth)
            outcome, actions = self._act(outcome)
        utterance = growth.utterance
        if not utterance.is_complete:
            self._cut.restart(_KEPT_OF_PAUSE if self._hear.is_settled(growth) else 0.0)
            self._hear.restart(growth)
        return Decision(
            hypothesis=heard,
            outcome=outcome,
            confidence=min(max(confidence, 0.0), 1.0),
            mode=mode,
            speech_start=utterance.speech_start,
            speech_end=utterance.speech_end,
            decided=self._clock(),
            is_partial=not utterance.is_complete,
            decided_by=decided_by,
            actions=actions,
        )

    def _accept(self, phrase: str, growth: Growth) -> None:
        self._judge.accept(phrase)
        if self._config.commands.get(phrase).is_halt:
            self._halted = growth.utterance.speech_end + growth.quiet

    def _act(self, match: Match) -> tuple[Match | NoMatch, tuple[Action, ...]]:
        outcome = step(self._state, Heard(self._config.commands.get(match.command)))
        self._state = outcome.state
        if outcome.rejection is not None:
            return match.rejected(outcome.rejection), ()
        return match, outcome.actions
