# SPDX-License-Identifier: BSD-3-Clause
"""When the voice node was last known to be well, by its heartbeats and when they were sent."""

from __future__ import annotations

import math

from rst_control.types import Cause, Reason


class Heartbeat:
    """Judges heartbeats by their age, not by their coming in.

    Over a network that is late but steady all heartbeats come in time, and a "stop" as late as
    they. So each counts from when it was sent; the clocks of both hosts have to agree for that, and
    where they do not, the node counts as silent.

    Args:
        allowed: Age of the newest heartbeat up to which the node counts as well [s].
    """

    def __init__(self, allowed: float) -> None:
        self._allowed, self._newest = allowed, -math.inf

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
        return self._newest

    def objection(self, now: float) -> Cause | None:
        """Why nothing spoken may move at a time [s], steady clock; None: it may."""
        silent = now - self._newest
        if silent <= self._allowed:
            return None
        words = f"voice node silent for {silent:.2f} s, allowed {self._allowed:.2f} s"
        if math.isinf(silent):
            words = "voice node without heartbeat; a spoken stop would not be heard"
        return Cause(Reason.VOICE_SILENT, words)
