# SPDX-License-Identifier: BSD-3-Clause
"""Watches recognition while it works: says when it hangs, and hears a "stop" in its place.

The spotter alone needs `spotter.yaml: alone` for a stop, because each false one interrupts work.
While recognition hangs nobody else hears, and the robot has been stopped for the hang: a false stop
costs nothing then, a missed one may. So `middle` is enough, from the beginning of the sound on that
recognition did not live to judge.
"""

from __future__ import annotations

from dataclasses import dataclass

from voice_assist.config import SpotterConfig
from voice_assist.pipeline.hang_detection import HangWatch
from voice_assist.spotter.spotter import Spotting


@dataclass(frozen=True)
class Seen:
    """One look at recognition."""

    hang: str  # why it counts as hanging; empty: it does not
    is_news: bool  # that has just begun, or ended
    spotted: float | None = None  # [nat] the spotter's score of a "stop" heard in its place


class RecognitionWatch:
    """Looked at again and again, by one thread.

    Args:
        hang_watch: Tells a hang from a wait for the processor.
        spotting: The spotter itself, not what the pipeline sees of it; None: there is none.
        config: Its thresholds.
    """

    def __init__(
        self, hang_watch: HangWatch, spotting: Spotting | None, config: SpotterConfig
    ) -> None:
        self._hang_watch, self._spotting, self._config = hang_watch, spotting, config
        self._hang = ""
        self._from = 0.0  # [s] clock time from which a "stop" counts, while recognition hangs

    def __call__(self, since: float | None, steady: float, now: float) -> Seen:
        """Look once.

        Args:
            since: When recognition began with its frame, steady clock [s]; None: it waits for one.
            steady: Present time, that clock [s].
            now: Present time, the clock of frames [s].
        """
        was_hung, self._hang = bool(self._hang), self._hang_watch.objection(since, steady)
        is_hung = bool(self._hang)
        if since is None or not is_hung:
            return Seen(self._hang, was_hung)
        if not was_hung:
            self._from = now - (steady - since)
        return Seen(self._hang, not was_hung, self._spot(now))

    def _spot(self, now: float) -> float | None:
        score = None if self._spotting is None else self._spotting.best(self._from)
        if score is None or score < self._config.middle:
            return None
        self._from = now + self._config.rearm_after
        return score
