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

NO_WORD = "no word from the alarm node"
_ROWS = 10  # alarms of the past shown at once


class AlarmScreen:
    """What the terminal shows; until the first `show` that nothing is known.

    Args:
        clock: Wall time [s].
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._is_known = False
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
        self._is_known = True

    def lose(self) -> None:
        """The alarm node is gone: what stands now is not known until the next `show`."""
        self._is_known = False

    def __rich__(self) -> Group:
        """All of it, for rich."""
        shown = self._others if self._is_known else ()
        others = [Text(f"  also: {other}", style="bold") for other in shown]
        past = [Text(f"  {row}", style="dim") for row in self._past]
        return Group(*self._head(), *others, Text(""), *past)

    def _head(self) -> list[Text]:
        if not self._is_known:
            return [Text(f" ? {NO_WORD} ", style="bold reverse")]
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
