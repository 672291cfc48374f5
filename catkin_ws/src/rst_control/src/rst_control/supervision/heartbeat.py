# SPDX-License-Identifier: BSD-3-Clause
"""When the voice node was last known to be well, by its heartbeats and when they were sent."""

from __future__ import annotations

import math
from dataclasses import dataclass

from rst_control.types import Cause, Reason


@dataclass(frozen=True)
class _Misdated:
    """Heartbeats that follow each other in time, and whose stamps are all too early or too late."""

    since: float  # [s] steady clock, when the first one came
    newest: float  # [s] the same, when the last one came
    late: float  # [s] of its stamp; below zero: it is ahead


class Heartbeat:
    """Judges heartbeats by their age, not by their coming in.

    Over a network that is late but steady all heartbeats come in time, and a "stop" as late as
    they. So each counts from when it was sent; the clocks of both hosts have to agree for that, and
    where they do not, the node counts as silent. What it says then names the clocks, once
    heartbeats with such stamps have come for as long as is allowed.

    Args:
        allowed: Age of the newest heartbeat up to which the node counts as well [s].
    """

    def __init__(self, allowed: float) -> None:
        self._allowed, self._newest = allowed, -math.inf
        self._misdated: _Misdated | None = None  # None: the newest stamp was as it should be

    def beat(self, sent: float, received: float, now: float) -> float:
        """Note a heartbeat, from one thread.

        Args:
            sent: Its stamp [s], clock of the day; 0: it has none, and counts as sent just now.
            received: When it came [s], clock of the day.
            now: The same [s], steady clock.

        Returns:
            When the node was last known to be well [s], steady clock.
        """
        late = received - sent if sent else 0.0
        if late >= -self._allowed:  # else that clock is ahead: how late it is nobody knows
            self._newest = max(self._newest, now - max(late, 0.0))
        self._misdated = self._misdating(late, now)
        return self._newest

    def objection(self, now: float) -> Cause | None:
        """Why nothing spoken may move at a time [s], steady clock; None: it may."""
        silent = now - self._newest
        if silent <= self._allowed:
            return None
        words = f"voice node silent for {silent:.2f} s, allowed {self._allowed:.2f} s"
        if math.isinf(silent):
            words = "voice node without heartbeat; a spoken stop would not be heard"
        return Cause(Reason.VOICE_SILENT, self._dated(now) or words)

    def _misdating(self, late: float, now: float) -> _Misdated | None:
        if abs(late) <= self._allowed:
            return None
        last = self._misdated
        goes_on = last is not None and now - last.newest <= self._allowed
        since = last.since if last is not None and goes_on else now
        return _Misdated(since, now, late)

    def _dated(self, now: float) -> str:
        """What is wrong with the stamps of heartbeats that come in time; empty: nothing.

        A few at once, after a cut of the network, are not yet heartbeats that come in time.
        """
        seen, allowed = self._misdated, self._allowed
        if seen is None or now - seen.newest > allowed or seen.newest - seen.since < allowed:
            return ""
        words = f"allowed {allowed:.2f} s: are the clocks of both hosts set"
        if seen.late < 0.0:
            return (
                f"voice node's heartbeats come, but are stamped {-seen.late:.2f} s ahead, {words}?"
            )
        return (
            f"voice node's heartbeats come, but are stamped {seen.late:.2f} s late, {words}, "
            "or is the network slow?"
        )
