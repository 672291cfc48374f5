# SPDX-License-Identifier: BSD-3-Clause
"""Detects that recognition hangs, and then takes a "stop" from the spotter alone.

The spotter alone needs `spotter.yaml: alone` for a stop, because each false one interrupts work.
While recognition hangs, only the spotter hears, and the robot is stopped already. A false stop then
costs nothing; a missed one may. So the lower threshold `middle` is enough. It applies from the
beginning of the sound that recognition did not decide.
"""

from __future__ import annotations

from dataclasses import dataclass

from voice_assist.config import SpotterConfig
from voice_assist.pipeline.hang_detection import HangWatch
from voice_assist.spotter.spotter import Spotting


@dataclass(frozen=True)
class RecognitionStatus:
    """State of recognition at one check."""

    hang: str  # why it counts as hanging; empty: it does not
    is_news: bool  # that has just begun, or ended
    spotted: float | None = None  # [nat] the spotter's score of a "stop" heard in its place


class RecognitionWatch:
    """Called periodically by one thread.

    Args:
        hang_watch: Distinguishes a hang from a wait for the processor.
        spotting: The spotter itself, not the pipeline's view of it; None: no spotter.
        config: Its thresholds.
    """

    def __init__(
        self, hang_watch: HangWatch, spotting: Spotting | None, config: SpotterConfig
    ) -> None:
        self._hang_watch, self._spotting, self._config = hang_watch, spotting, config
        self._hang = ""
        self._from = 0.0  # [s] clock time from which a "stop" counts, while recognition hangs

    def __call__(self, since: float | None, steady: float, now: float) -> RecognitionStatus:
        """Check once.

        Args:
            since: When recognition began with its frame, steady clock [s]; None: it waits for one.
            steady: Present time, that clock [s].
            now: Present time, the clock of frames [s].
        """
        was_hung, self._hang = bool(self._hang), self._hang_watch.objection(since, steady)
        is_hung = bool(self._hang)
        if since is None or not is_hung:
            return RecognitionStatus(self._hang, was_hung)
        if not was_hung:
            self._from = now - (steady - since)
        return RecognitionStatus(self._hang, not was_hung, self._spot(now))

    def _spot(self, now: float) -> float | None:
        score = None if self._spotting is None else self._spotting.best(self._from)
        if score is None or score < self._config.middle:
            return None
        self._from = now + self._config.rearm_after
        return score
