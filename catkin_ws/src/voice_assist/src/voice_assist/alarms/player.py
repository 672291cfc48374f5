# SPDX-License-Identifier: BSD-3-Clause
"""Plays alarms from a thread of its own, so that no sound device ever delays anything."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Protocol

from voice_assist.alarms.types import Alarm, Earcon
from voice_assist.errors import AudioError


class Output(Protocol):
    """A way out for sound."""

    def play(self, earcon: Earcon, is_cut: Callable[[], bool]) -> None:
        """Play to the end, or until `is_cut` says so.

        Raises:
            AudioError: It cannot be heard.
        """
        ...


class Player:
    """One slot for what comes next: the higher priority, else the newer, takes it.

    Args:
        output: Plays.
        report: Told once what is wrong with it, and with an empty text that it is well again.
    """

    def __init__(self, output: Output, report: Callable[[str], None]) -> None:
        self._output, self._report = output, report
        self._changed = threading.Condition()
        self._next: Alarm | None = None
        self._is_over = False
        self.trouble = ""
        self._thread = threading.Thread(target=self._run, name="alarm player", daemon=True)

    def __enter__(self) -> Player:
        self._thread.start()
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

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._next is not None or self._is_over)
                if self._is_over or self._next is None:
                    return
                alarm, self._next = self._next, None
            self._play(alarm)

    def _play(self, alarm: Alarm) -> None:
        trouble = ""
        try:
            self._output.play(alarm.earcon, lambda: self._is_cut(alarm))
        except AudioError as error:
            trouble = str(error)
        except Exception as error:  # top of the thread: alarms go on being seen
            trouble = f"sound failed: {error!r}"
        if trouble != self.trouble:
            self.trouble = trouble
            self._report(trouble)

    def _is_cut(self, playing: Alarm) -> bool:
        coming = self._next
        return self._is_over or (coming is not None and coming.priority > playing.priority)
