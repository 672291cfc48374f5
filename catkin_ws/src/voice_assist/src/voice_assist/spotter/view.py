# SPDX-License-Identifier: BSD-3-Clause
"""What the pipeline may know of a spotter that is ahead of it or behind it."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

from voice_assist.spotter.spotter import NEWEST, Spotted, Spotting
from voice_assist.types import Frame


class SpotterView:
    """Shows what was heard up to the pipeline's own frame, and nothing newer.

    While the spotter is behind, and once it has failed, it says that nobody listens. Then the
    recogniser decides alone: what was not heard yet must not keep a stop from being taken.
    """

    def __init__(self, spotter: Spotting) -> None:
        """Nothing was heard.

        Args:
            spotter: Its scores are read here; the subclass lets it hear.
        """
        self._spotter = spotter
        self._spotted: deque[tuple[int, Spotted]] = deque()  # with the sample that follows
        self._heard_until = 0  # index of the sample that follows all that was heard
        self._shown_until = NEWEST  # of which the pipeline sees so much
        self._is_deaf = False  # it has failed, as the pipeline knows
        self._is_late = False  # it has not heard the pipeline's newest frame

    def best(self, since: float, until: int = NEWEST) -> float | None:
        """Highest score that the pipeline may know; None: nobody listens in time."""
        if self._is_deaf or self._is_late:
            return None
        return self._spotter.best(since, min(until, self._shown_until))

    def reset(self) -> None:
        """Nothing: the stream that the spotter hears goes on."""

    def _note_heard(self, frame: Frame, spotted: Spotted | None) -> None:
        """A frame was heard; what was spotted in it was sent at once."""
        if spotted is not None:
            self._spotted.append((frame.next_sample, replace(spotted, is_sent=True)))
        self._heard_until = frame.next_sample

    def _show(self, frame: Frame, is_late: bool) -> Spotted | None:
        """What was spotted up to the pipeline's frame, each once."""
        self._shown_until = min(self._heard_until, frame.next_sample)
        self._is_late = is_late
        if self._spotted and self._spotted[0][0] <= frame.next_sample:
            return self._spotted.popleft()[1]
        return None
