# SPDX-License-Identifier: BSD-3-Clause
"""From frames of sound to decisions; `Pipeline.__call__` is the whole way, top to bottom."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from voice_assist.audio.denoise import Denoiser
from voice_assist.audio.robot_speech import RobotSpeech, RobotSpeechChange
from voice_assist.audio.source import Clock, GapWatch
from voice_assist.audio.talk_gate import TalkChange, TalkGate
from voice_assist.config import VoiceConfig
from voice_assist.intent.dialogue import (
    AT_START,
    Answered,
    CommandRecognized,
    DialogueState,
    ModeReported,
    step,
)
from voice_assist.intent.early_decision import DecisionContext
from voice_assist.intent.mapper import Mapper
from voice_assist.intent.question import Question
from voice_assist.intent.rejection_rules import RejectionRules
from voice_assist.pipeline.decider import Decider
from voice_assist.pipeline.partial_decoding import PartialDecoder
from voice_assist.pipeline.stop_decider import StopInSound, Verdict
from voice_assist.side_inputs import Observer, SideInput, SideInputKind, ignore
from voice_assist.spotter.fusion import StopFusion
from voice_assist.spotter.spotter import Spotted
from voice_assist.types import (
    RATE,
    Action,
    Ask,
    Frame,
    Halt,
    Lost,
    Match,
    Mode,
    NoMatch,
    Partial,
    Rejection,
    RejectionReason,
    Samples,
    Utterance,
    UtteranceDecision,
    frozen_samples,
)
from voice_assist.vad.detector import Detector, OverloadRecovery
from voice_assist.vad.endpointer import Endpointer
from voice_assist.vad.segmenter import PartialUtterance, Segmenter

if TYPE_CHECKING:
    from voice_assist.recognizer.recognizer import Recognizer
    from voice_assist.speaker.gate import Gate

Event = Partial | UtteranceDecision | Lost

_SET_BACK = 0.5  # [s] by which a frame is stamped before the one before it, where a clock was set
_PROGRESS = RATE  # samples between two notes of how far recognition has come
_KEPT_OF_NOISE = 0.5  # [s] before a decoder pass that found nothing, which may begin a word
_KEPT_OF_PAUSE = 0.064  # [s] before a decision in a pause that may begin the next word


class Pipeline:
    """Recognises commands in a stream, frame by frame."""

    def __init__(
        self,
        config: VoiceConfig,
        recognizer: Recognizer,
        detector: Detector,
        clock: Clock,
        stop_fusion: StopFusion | None = None,
        observer: Observer = ignore,
        gate: Gate | None = None,
        stop_in_sound: StopInSound | None = None,
    ) -> None:
        """Join the stages.

        Args:
            config: Of all stages.
            recognizer: Makes text of sound.
            detector: Gives the probability of speech.
            clock: The one that stamps the frames [s].
            stop_fusion: The spotter and the rule that joins it; without it the recogniser is alone.
            observer: Gets all other inputs, and all sound that is skipped for lack of time.
            gate: Refuses motions in other voices; None: any voice may move the robot.
            stop_in_sound: The spotter over talk; None: there is none.
        """
        self._config, self._clock, self._observer = config, clock, observer
        self._next_sample = 0  # index of the sample that follows all those taken
        self._heard_until = float("-inf")  # [s] stamp of that sample
        self._recognizer = recognizer
        self._gap_watch = GapWatch()
        self._denoiser = Denoiser(config.audio.denoise)
        self._overload_recovery = OverloadRecovery()
        self._detector = detector
        self._endpointer = Endpointer(config.audio.vad)
        self._segmenter = Segmenter(config.audio.vad)
        self._stop_fusion = stop_fusion or StopFusion(config.spotter, None)
        mapper, early = Mapper(config.commands), config.recognizer.early
        self._decoder = PartialDecoder(recognizer, early, clock, observer, mapper.cannot_become)
        self._robot_speech = RobotSpeech(config.audio.robot_speech)
        self._talk_gate = TalkGate()
        rejection_rules = RejectionRules(config, self._robot_speech, self._talk_gate, gate)
        rules = self._stop_fusion, rejection_rules, stop_in_sound
        self._decider = Decider(config, mapper, self._decoder, *rules)
        self._dialogue_state = AT_START
        self._question = Question(config.recognizer.ask, config.commands.said_twice)
        self._shown = ""  # the transcript published last
        self._start_utterance()

    def __call__(self, frame: Frame) -> tuple[Event, ...]:
        """Take the next frame of the stream; gives what came of it, oldest first."""
        events = self._check_stream(frame)
        cleaned = self._denoiser(frame.samples)
        if self._overload_recovery.is_over(frame):
            self._detector.reset()
        endpoint = self._endpointer(self._detector(cleaned), frame.duration)
        is_cleaned = self._config.audio.denoise.mode == "on"  # for the recogniser alone
        heard = replace(frame, samples=cleaned) if is_cleaned else frame
        partial = self._segmenter(heard, endpoint)
        if partial is not None:  # before a stop, after which what was said so far counts no more
            self._decider.stops.hear(partial.utterance.samples)
        if spotted := self._stop_fusion.update(frame):
            events += self._decide_spotted(spotted, partial)
        if partial is None:
            return events
        if self._decoder(partial, frame, frame.stream_end, self._window_alone(frame)):
            events += (*self._transcribed(frame), *self._decide(partial, frame))
            self._forget_noise(partial, frame.stream_end)
        if partial.utterance.is_complete:
            events += (Partial("", frame.stamp),) if self._shown else ()
            self._start_utterance()
        return events

    def _check_stream(self, frame: Frame) -> tuple[Event, ...]:
        """Note progress, and begin anew after a gap in the stream."""
        self._next_sample = frame.next_sample
        if frame.stamp < self._heard_until - _SET_BACK:  # the clock was set back: no time compares
            self._question.close()
            self._talk_gate.reset()
        self._heard_until = frame.end
        if frame.first_sample // _PROGRESS != self._next_sample // _PROGRESS:
            self._observer(SideInput(SideInputKind.HEARD, frame.first_sample))
        lost = self._gap_watch(frame)
        if lost is None:
            return ()
        self._observer(SideInput(SideInputKind.LOST, frame.first_sample))
        self._question.close()
        self._detector.reset()
        self._endpointer.reset()
        self._segmenter.break_at(frame.stamp)
        shown = (Partial("", frame.stamp),) if self._shown else ()
        self._start_utterance()
        return (*shown, Lost(lost, frame.stamp))

    def _window_alone(self, frame: Frame) -> float:
        """Length of the last part that is decoded by itself too [s]; 0: none is."""
        if self._robot_speech.is_in(frame.stamp):
            return self._config.audio.robot_speech.window
        return self._config.moving.window if frame.is_moving else 0.0

    def _transcribed(self, frame: Frame) -> tuple[Event, ...]:
        """The transcript so far, where it has changed."""
        text = self._decoder.transcript.text if self._decoder.transcript else ""
        if text == self._shown:
            return ()
        self._shown = text
        return (Partial(text, frame.end),)

    def _decide(self, partial: PartialUtterance, frame: Frame) -> tuple[Event, ...]:
        """What the newest transcript comes to, if it is decided now."""
        transcript = self._decoder.transcript
        if transcript is None:
            return ()
        is_whole = partial.is_whole and not self._decoder.is_window
        spotted = self._stop_fusion.best(frame.end)
        is_complete = partial.utterance.is_complete
        has_paused = self._decoder.has_paused(partial)
        where = frame.stream_end, has_paused, is_complete, is_whole, spotted
        robot = frame.is_moving, self._robot_speech.is_in(frame.stamp)
        is_active = self._dialogue_state.mode is Mode.ACTIVE
        context = DecisionContext(*where, *robot, is_active)
        verdict = self._decider(transcript, partial, context)
        return () if verdict is None else (self._conclude(verdict, partial),)

    def _decide_spotted(
        self, spotted: Spotted, partial: PartialUtterance | None
    ) -> tuple[Event, ...]:
        """The spotter fired alone; nothing new where the recogniser was quicker."""
        verdict = self._decider.stops.spotted(spotted)
        if verdict is None:
            return ()
        silent = Utterance(frozen_samples(np.zeros(0)), spotted.time, spotted.time, False)
        begun = partial or PartialUtterance(silent, 0.0, False, 0.0)
        decision = self._conclude(verdict, begun)
        if partial is None:  # endpointing has noticed no speech: what is said next is new
            self._decider.start_utterance()
        if spotted.is_sent:
            left = tuple(a for a in decision.actions if not isinstance(a, Halt))
            decision = replace(decision, actions=left)
        return (decision,)

    def _conclude(self, verdict: Verdict, partial: PartialUtterance) -> UtteranceDecision:
        """Let the dialogue act on it, and make ready for the rest of the utterance."""
        mode, utterance = self._dialogue_state.mode, partial.utterance
        verdict = self._confirmed(verdict, partial)
        outcome = verdict.outcome
        actions: tuple[Action, ...] = ()
        is_answer = self._question.is_open(utterance.speech_start)
        is_own = self._robot_speech.is_in(utterance.speech_start)
        if isinstance(outcome, Match) or not is_own:
            self._question.close()
        if isinstance(outcome, Match):
            self._decider.accept(self._config.commands.get(outcome.command), partial)
            outcome, actions = self._act(outcome)
        elif outcome.rejection.reason is RejectionReason.NEARLY_SURE:
            outcome, actions = self._ask(outcome, utterance, partial.quiet, is_answer)
        if not utterance.is_complete:
            self._segmenter.restart(_KEPT_OF_PAUSE if self._decoder.is_settled(partial) else 0.0)
            self._decoder.restart(partial)
            self._decider.stops.start_sound()
        return UtteranceDecision(
            hypothesis=verdict.hypothesis,
            outcome=outcome,
            confidence=min(max(verdict.confidence, 0.0), 1.0),
            mode=mode,
            speech_start=utterance.speech_start,
            speech_end=utterance.speech_end,
            decided=self._clock(),
            is_partial=not utterance.is_complete,
            decided_by=verdict.decided_by,
            actions=actions,
        )

    def _act(self, match: Match) -> tuple[Match | NoMatch, tuple[Action, ...]]:
        command = self._config.commands.get(match.command)
        outcome = step(self._dialogue_state, CommandRecognized(command))
        self._dialogue_state = outcome.state
        if outcome.rejection is not None:
            return match.rejected(outcome.rejection), ()
        return match, outcome.actions

    def _confirmed(self, verdict: Verdict, partial: PartialUtterance) -> Verdict:
        """The motion that was asked for, where it is said again or the whole utterance says yes."""
        again = self._question.said_again(verdict.outcome, partial.utterance.speech_start)
        if again is not None:
            return replace(verdict, outcome=again)
        is_whole = partial.is_whole and not self._decoder.is_window
        if isinstance(verdict.outcome, Match) or not (is_whole and partial.utterance.is_complete):
            return verdict
        heard = verdict.hypothesis
        command = self._question.confirmed(heard.text, partial.utterance.speech_start)
        return self._decider.confirmed(command, heard, partial) if command else verdict

    def _ask(
        self, outcome: NoMatch, utterance: Utterance, quiet: float, is_answer: bool
    ) -> tuple[NoMatch, tuple[Action, ...]]:
        """Ask for a motion that is nearly sure, unless it answers a question itself."""
        command = self._config.commands.get(outcome.nearest_command)
        refused = step(self._dialogue_state, CommandRecognized(command)).rejection
        if is_answer and not self._question.is_repeated:
            refused = Rejection(RejectionReason.UNSURE, "nearly sure again; it was asked once")
        if refused is not None:
            return replace(outcome, rejection=refused), ()
        said = utterance.speech_end
        self._question.ask(command.phrase, said, said + quiet)
        return outcome, (Ask(command.phrase),)

    def _forget_noise(self, partial: PartialUtterance, time: float) -> None:
        """Keep long noise, which the detector takes for speech, from hiding a command in it.

        What was said before it is over, as after a pause. Talk in which one pass found nothing is
        no noise: were it forgotten, its last word would pass for all that was said.
        """
        length = len(partial.utterance.samples) / RATE
        wordless = min(length, time - self._decoder.worded_at)
        if wordless > self._config.recognizer.early.noise_after:
            self._segmenter.forget(_KEPT_OF_NOISE)
            self._decider.start_utterance()

    def _start_utterance(self) -> None:
        self._decider.start_utterance()
        self._decoder.reset()
        self._shown = ""

    @property
    def state(self) -> DialogueState:
        """Of the dialogue."""
        return self._dialogue_state

    def set_mode(self, mode: Mode, reason: str) -> None:
        """Put the dialogue into a mode."""
        self._question.close()
        self._dialogue_state = DialogueState(mode, reason)

    def answer(self, answered: Answered) -> tuple[Action, ...]:
        """Take the controller's reply to a command; gives what to do about it."""
        reply = answered.command, answered.is_accepted, answered.message
        self._observer(SideInput(SideInputKind.ANSWERED, self._next_sample, 0, *reply))
        outcome = step(self._dialogue_state, answered)
        self._dialogue_state = outcome.state
        return outcome.actions

    def question_shown(self, time: float) -> None:
        """Take that people learn of a question only now: its time begins [s]."""
        self._observer(SideInput(SideInputKind.ASKED, self._next_sample, time=time))
        self._question.put(time)

    def answer_by_hand(self, command: str, is_yes: bool) -> tuple[Action, ...] | None:
        """Take a person's answer to a question; gives what to do, None: it is not asked."""
        if not self._question.is_about(command, self._heard_until):
            return None
        self._observer(
            SideInput(SideInputKind.BY_HAND, self._next_sample, 0, command, is_accepted=is_yes)
        )
        self._question.close()
        if not is_yes:
            return ()
        outcome = step(self._dialogue_state, CommandRecognized(self._config.commands.get(command)))
        self._dialogue_state = outcome.state
        return None if outcome.rejection is not None else outcome.actions

    def follow(self, mode: Mode) -> tuple[Action, ...]:
        """Take the robot's mode; gives what to do about it."""
        if mode is not self._dialogue_state.mode:
            found = SideInput(SideInputKind.ROBOT_MODE, self._next_sample, mode=mode.value)
            self._observer(found)
            self._question.close()
        outcome = step(self._dialogue_state, ModeReported(mode))
        self._dialogue_state = outcome.state
        return outcome.actions

    def robot_spoke(self, change: RobotSpeechChange) -> None:
        """Take that a loudspeaker of the robot's own speaks, or ended."""
        spoken = SideInput(SideInputKind.SPEAKING, self._next_sample, time=change.time)
        self._observer(replace(spoken, is_speaking=change.is_speaking))
        self._robot_speech.update(change)
        if not change.is_speaking:
            self._question.wait(change.time, change.time + self._config.audio.robot_speech.tail)

    def talk_changed(self, change: TalkChange) -> None:
        """Take that a pedal lets voice count from now on, or not; a stop always counts."""
        noted = SideInput(SideInputKind.TALK, self._next_sample, time=change.time)
        self._observer(replace(noted, is_open=change.is_open))
        self._talk_gate.update(change)

    def warm_up(self, samples: Samples) -> None:
        """Let the recogniser do once what it does only once, on any sound, shape (n,)."""
        self._recognizer.transcribe(samples)
        self._recognizer.score(samples, self._config.commands.fixed_phrases)
        self.reset()

    def reset(self) -> None:
        """Forget the stream so far, and keep the mode."""
        self._gap_watch = GapWatch()
        self._overload_recovery = OverloadRecovery()
        of_sound = (self._denoiser, self._detector, self._endpointer, self._segmenter)
        beside = (self._stop_fusion, self._robot_speech, self._talk_gate, self._decider)
        for stage in (*of_sound, *beside):
            stage.reset()
        self._question.close()
        self._start_utterance()
