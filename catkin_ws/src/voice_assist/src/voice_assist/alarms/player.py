# SPDX-License-Identifier: BSD-3-Clause
"""Plays alarms from a thread of its own, so that no sound device ever delays anything."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Protocol

from voice_assist.alarms.types import Alarm, Earcon
from voice_assist.errors import AudioError, VoiceError


class Output(Protocol):
    """A way out for sound."""

    def play(self, earcon: Earcon, is_cut: Callable[[], bool]) -> None:
        """Play to the end, or until `is_cut` says so.

        Raises:
            AudioError: It cannot be heard.
        """
        ...


class Voice(Protocol):
    """Says an answer after its tone."""

    def prepare(self) -> None:
        """Make ready what takes time, in a thread of its own; until then nothing is said.

        Raises:
            VoiceError: Nothing can be said, and why.
        """
        ...

    def say(self, sentence: str, is_cut: Callable[[], bool]) -> None:
        """Say it to the end, or until `is_cut` says so.

        Raises:
            AudioError: It cannot be heard.
        """
        ...


class Player:
    """One slot for what comes next: the higher priority, else the newer, takes it.

    Args:
        output: Plays.
        report: Called once with what is wrong with it, and with an empty text when it is well.
        voice: Says the answers; None: nobody does.
        quiet_for: After `hush` nothing is said for so long [s].
        report_answers: Called once with why no answer is spoken, while tones may be heard; None:
            `report` is.
    """

    def __init__(
        self,
        output: Output,
        report: Callable[[str], None],
        voice: Voice | None = None,
        quiet_for: float = 0.0,
        report_answers: Callable[[str], None] | None = None,
    ) -> None:
        self._output, self._report, self._voice = output, report, voice
        self._report_answers = report_answers or report
        self._quiet_for, self._quiet_until = quiet_for, float("-inf")  # [s] steady clock
        self._changed = threading.Condition()
        self._next: Alarm | None = None
        self._is_over = False
        self.is_muted = False  # while it is true nothing is said, and what is being said ends
        self.trouble = self._unsaid = ""
        self._thread = threading.Thread(target=self._run, name="alarm player", daemon=True)

    def __enter__(self) -> Player:
        self._thread.start()
        if self._voice is not None:
            args = (self._voice,)
            threading.Thread(target=self._prepare, args=args, name="answers", daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        with self._changed:
            self._is_over = True
            self._changed.notify()
        self._thread.join(timeout=1.0)

    def offer(self, alarm: Alarm) -> None:
        """Ask for an alarm to be heard, at once; never waits for the device."""
        with self._changed:
            if self._next is None or alarm.priority >= self._next.priority:
                self._next = alarm
                self._changed.notify()

    def hush(self) -> None:
        """A stop: end what is being said at once, and say nothing for a while."""
        self._quiet_until = time.monotonic() + self._quiet_for

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._next is not None or self._is_over)
                if self._is_over or self._next is None:
                    return
                alarm, self._next = self._next, None
            self._play(alarm)

    def _prepare(self, voice: Voice) -> None:
        try:
            voice.prepare()
        except Exception as error:  # alarms go on being heard, or at least seen
            words = str(error) if isinstance(error, VoiceError) else repr(error)
            self._voice = None
            self._report_answers(f"no answer is spoken: {words}")

    def _play(self, alarm: Alarm) -> None:
        voice = self._voice  # which `_prepare` may take away meanwhile
        trouble = _trouble_of(lambda: self._output.play(alarm.earcon, lambda: self._is_cut(alarm)))
        if trouble != self.trouble:
            self.trouble = trouble
            self._report(trouble)
        if alarm.answer and voice is not None and not trouble:
            self._say(voice, alarm)

    def _say(self, voice: Voice, alarm: Alarm) -> None:
        unsaid = _trouble_of(
            lambda: voice.say(alarm.answer, lambda: self._is_hushed() or self._is_cut(alarm))
        )
        if unsaid and unsaid != self._unsaid:
            self._report_answers(f"no answer is spoken: {unsaid}")
        self._unsaid = unsaid

    def _is_hushed(self) -> bool:
        return self.is_muted or time.monotonic() < self._quiet_until

    def _is_cut(self, playing: Alarm) -> bool:
        coming = self._next
        return self._is_over or (coming is not None and coming.priority > playing.priority)


def _trouble_of(play: Callable[[], None]) -> str:
    """What went wrong with a sound, in words; empty: nothing did."""
    try:
        play()
    except AudioError as error:
        return str(error)
    except Exception as error:  # in the player's thread: alarms go on being seen
        return f"sound failed: {error!r}"
    return ""
