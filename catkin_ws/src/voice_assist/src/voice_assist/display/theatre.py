# SPDX-License-Identifier: BSD-3-Clause
"""Gathers what the system reports, from any thread, into snapshots."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from voice_assist.display.phase_clock import PhaseClock
from voice_assist.display.snapshot import (
    AlarmPart,
    HearingPart,
    Picture,
    PicturePart,
    QuestionPart,
    RecordingPart,
    RobotPart,
    Snapshot,
    TissuePart,
    UtterancePart,
)
from voice_assist.display.words import WordRule, words_that_count

QUIET = -100.0  # [dB] of full scale, silence
PARTIAL_FOR = 3.0  # [s] that text as it is heard is shown without more of it
DEVICE_FOR = 10.0  # [s] that what came of a call is shown
OWN_VOICE_FOR = 1.0  # [s] after the robot's own voice, in which what it said may be decided
T = TypeVar("T")


@dataclass(frozen=True)
class _News(Generic[T]):
    value: T
    at: float  # [s] steady clock
    stamp: float = 0.0  # [s] by the clock of who sent it; 0: it does not say

    def age(self, now: float) -> float:
        return max(0.0, now - self.at)


def _stamped(before: _News[T] | None, value: T, now: float, stamp: float) -> _News[T]:
    """News of who stamps them: with the stamp of those before, they are as old as those."""
    if before is not None and stamp == before.stamp != 0.0:
        now = before.at
    return _News(value, now, stamp)


@dataclass(frozen=True)
class Limits:
    """What the controller brakes at; None: unknown."""

    tension: float | None = None  # [N]
    rcm: float | None = None  # [m]


class Theatre:
    """The newest of everything.

    Args:
        old_after: Age from which viewers are shown a part as old [s].
        clock: Steady clock [s].
        wall: Wall clock [s since 1970].
    """

    def __init__(
        self, old_after: float, clock: Callable[[], float], wall: Callable[[], float]
    ) -> None:
        self._old_after, self._clock, self._wall = old_after, clock, wall
        self._lock = threading.Lock()
        self._phase = PhaseClock()
        self._robot: _News[tuple[RobotPart, TissuePart]] | None = None
        self._sound: _News[float] | None = None
        self._heard_voice = False
        self._partial: _News[str] | None = None
        self._utterance: _News[UtterancePart] | None = None
        self._question: _News[str] | None = None
        self._has_waited = False  # the question, for the robot's own voice
        self._speaking: _News[bool] | None = None  # the robot
        self._device: _News[str] | None = None
        self._mode = self._microphone = self._trouble = ""
        self._alarm: AlarmPart | None = None
        self._recording: _News[str] | None = None
        self._file: _News[str] | None = None
        self._free: int | None = None
        self._picture: _News[Picture] | None = None
        self._picture_period = 0.0
        self._invalid_reason = self._distrust = ""
        self.limits = Limits()
        self.answer_within = 0.0  # [s] after a question in which it can be answered
        self.rules: Sequence[WordRule] = ()

    # --- what comes in

    def see_robot(self, robot: RobotPart, tissue: TissuePart, stamp: float = 0.0) -> None:
        """A state of the controller.

        Args:
            robot: What it does.
            tissue: What it measures.
            stamp: When its loop was there, by its clock [s]; one that stands still is no news of
                it. 0: it does not say.
        """
        with self._lock:
            now = self._clock()
            self._robot = _stamped(self._robot, (robot, tissue), now, stamp)
            self._phase.report(f"{robot.command}/{robot.phase}", robot.progress, now)

    def see_tension_invalid(self, reason: str) -> None:
        """Why the robot says that the tension is invalid; empty: it is valid."""
        self._invalid_reason = reason

    def see_tension_distrust(self, reason: str) -> None:
        """Why the controller does not rely on the tension, or has none; empty: it does."""
        self._distrust = reason

    def see_sound(self, level: float) -> None:
        """The level of a block of sound [dB of full scale]."""
        with self._lock:
            loudest = level if self._sound is None else max(level, self._sound.value)
            self._sound = _News(loudest, self._clock())

    def see_partial(self, text: str) -> None:
        """Text as it is heard."""
        self._partial = _News(text, self._clock())

    def see_utterance(
        self, utterance: UtterancePart, asks_for: str = "", *, is_rest: bool = False
    ) -> None:
        """A decision of the recogniser ends what was shown of the words before it.

        That is the text that led to it, a question, and what a device answered.

        Args:
            utterance: What was decided.
            asks_for: Command that is asked for, since it was nearly sure; empty: none.
            is_rest: It is the rest of a breath, as the end of a "stop" that was taken before its
                end. A command that was taken stays in place of it.
        """
        with self._lock:
            if is_rest and self._utterance is not None and self._utterance.value.command:
                return
            if asks_for or utterance.command or not self._is_own_voice():
                self._question = _News(asks_for, self._clock()) if asks_for else None
                self._has_waited = False
            self._utterance = _News(utterance, self._clock())
            self._partial = self._device = None

    def see_speaking(self, is_speaking: bool) -> None:
        """The robot's own voice begins or has ended; a question's time begins anew then, once."""
        with self._lock:
            now = self._clock()
            has_ended = not is_speaking and self._speaking is not None and self._speaking.value
            asked = self._question_part(now)
            if asked is not None and has_ended and not self._has_waited:
                self._question, self._has_waited = _News(asked.command, now), True
            self._speaking = _News(is_speaking, now)

    def _is_own_voice(self) -> bool:
        """Whether what was decided now may be what the robot itself said."""
        spoke = self._speaking
        return spoke is not None and (spoke.value or spoke.age(self._clock()) < OWN_VOICE_FOR)

    def see_device(self, words: str) -> None:
        """What came of a call to a device."""
        self._device = _News(words, self._clock())

    def end_question(self) -> None:
        """The question was answered."""
        self._question = None

    def see_mode(self, mode: str) -> None:
        """Standby or active."""
        self._mode = mode

    def see_voice_health(self, microphone: str, trouble: str) -> None:
        """By which microphone the voice node hears, and why it may not."""
        self._heard_voice = True
        self._microphone, self._trouble = microphone, trouble

    def see_alarm(self, alarm: AlarmPart | None) -> None:
        """What stands first; None: no alarm node is there and works."""
        self._alarm = alarm

    def see_recording(self, problem: str) -> None:
        """The recorder's heartbeat; empty: everything is recorded."""
        self._recording = _News(problem, self._clock())

    def see_file(self, file: str) -> None:
        """The file that is recorded; empty: none."""
        with self._lock:
            self._file = _News(file, self._clock()) if file else None

    def see_recorded_for(self, file: str, seconds: float) -> None:
        """How long a file has been recorded for, which may be longer than it is known here."""
        with self._lock:
            known = self._file
            if known is not None and known.value == file:
                self._file = _News(file, min(known.at, self._clock() - seconds))

    def see_free_space(self, free: int | None) -> None:
        """Of the recorder's disk [B]; None: unknown."""
        self._free = free

    def see_picture(self, kind: str, data: bytes, stamp: float) -> None:
        """A picture of the scene.

        Args:
            kind: image/png or image/jpeg.
            data: The file.
            stamp: When it was taken, by the camera's clock [s]; one that stands still makes it no
                newer. 0: the camera does not say.
        """
        with self._lock:
            number = 1 if self._picture is None else self._picture.value.number + 1
            picture = Picture(number, kind, data, stamp)
            self._picture = _stamped(self._picture, picture, self._clock(), stamp)

    def see_picture_period(self, period: float) -> None:
        """How often a picture can come [s]."""
        self._picture_period = period

    # --- what goes out

    @property
    def picture(self) -> Picture | None:
        """The newest."""
        news = self._picture
        return None if news is None else news.value

    def snapshot(self) -> Snapshot:
        """Everything as it is now; the level counts from the last snapshot on."""
        with self._lock:
            now = self._clock()
            return Snapshot(
                time=self._wall(),
                steady=now,
                old_after=self._old_after,
                robot=self._robot_part(now),
                tissue=self._tissue_part(now),
                hearing=self._hearing_part(now),
                alarm=self._alarm,
                recording=self._recording_part(now),
                picture=self._picture_part(now),
            )

    def _robot_part(self, now: float) -> RobotPart | None:
        if self._robot is None:
            return None
        robot = self._robot.value[0]
        words = words_that_count(self.rules, self._mode, robot.state, robot.is_tissue_held)
        remaining = self._phase.remaining if robot.state in ("moving", "stopping") else None
        return replace(robot, remaining=remaining, words=words, age=self._robot.age(now))

    def _tissue_part(self, now: float) -> TissuePart | None:
        if self._robot is None:
            return None
        return replace(
            self._robot.value[1],
            invalid_reason=self._invalid_reason or self._distrust,
            tension_limit=self.limits.tension,
            rcm_limit=self.limits.rcm,
            age=self._robot.age(now),
        )

    def _hearing_part(self, now: float) -> HearingPart | None:
        sound, partial, said = self._sound, self._partial, self._utterance
        if sound is None and not self._heard_voice:
            return None
        if sound is not None:
            self._sound = _News(QUIET, sound.at)
        is_shown = partial is not None and partial.age(now) < PARTIAL_FOR
        return HearingPart(
            level=QUIET if sound is None else sound.value,
            partial=partial.value if partial is not None and is_shown else "",
            mode=self._mode,
            microphone=self._microphone,
            trouble=self._trouble,
            utterance=None if said is None else replace(said.value, age=said.age(now)),
            question=self._question_part(now),
            device=self._device_words(now),
            age=float("inf") if sound is None else sound.age(now),
        )

    def _question_part(self, now: float) -> QuestionPart | None:
        asked = self._question
        remaining = 0.0 if asked is None else self.answer_within - asked.age(now)
        return None if asked is None or remaining <= 0.0 else QuestionPart(asked.value, remaining)

    def _device_words(self, now: float) -> str:
        device = self._device
        return device.value if device is not None and device.age(now) < DEVICE_FOR else ""

    def _recording_part(self, now: float) -> RecordingPart | None:
        if self._recording is None:
            return None
        file = self._file
        return RecordingPart(
            problem=self._recording.value,
            file="" if file is None else file.value,
            since=None if file is None else file.age(now),
            free=self._free,
            age=self._recording.age(now),
        )

    def _picture_part(self, now: float) -> PicturePart | None:
        news = self._picture
        if news is None:
            return None
        return PicturePart(news.value.number, self._picture_period, news.age(now))
