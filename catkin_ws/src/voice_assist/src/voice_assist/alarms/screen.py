# SPDX-License-Identifier: BSD-3-Clause
"""Alarms in the terminal: colour, symbol and words, so that none of them is needed alone."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from datetime import datetime

from rich.console import Group
from rich.text import Text

from voice_assist.alarms.appearance import APPEARANCES, headline, is_lit, line
from voice_assist.alarms.types import AlarmText

_ROWS = 10  # alarms of the past shown at once


class AlarmScreen:
    """What the terminal shows.

    Args:
        clock: Wall time [s].
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._alarm: AlarmText | None = None
        self._is_acknowledged = False
        self._others: tuple[str, ...] = ()
        self._past: deque[str] = deque(maxlen=_ROWS)

    def show(self, alarm: AlarmText | None, is_acknowledged: bool, others: tuple[str, ...]) -> None:
        """Take over what stands now.

        Args:
            alarm: What comes first; None: all is well.
            is_acknowledged: It no longer sounds.
            others: What else stands, a line each.
        """
        if alarm is not None and alarm != self._alarm:
            when = datetime.fromtimestamp(self._clock()).strftime("%H:%M:%S")
            self._past.append(f"{when}  {line(alarm)}")
        self._alarm, self._is_acknowledged, self._others = alarm, is_acknowledged, others

    def __rich__(self) -> Group:
        """All of it, for rich."""
        others = [Text(f"  also: {other}", style="bold") for other in self._others]
        past = [Text(f"  {row}", style="dim") for row in self._past]
        return Group(*self._head(), *others, Text(""), *past)

    def _head(self) -> list[Text]:
        alarm = self._alarm
        if alarm is None:
            return [Text(" ○ all is well ", style="green")]
        style = APPEARANCES[alarm.priority].style
        if not self._is_acknowledged and not is_lit(alarm.priority, self._clock()):
            style = "bold"
        seen = " (acknowledged)" if self._is_acknowledged else ""
        return [
            Text(f" {headline(alarm)}{seen} ", style=style),
            Text(f"  why:  {alarm.cause}"),
            Text(f"  next: {alarm.next_step}", style="bold"),
        ]
