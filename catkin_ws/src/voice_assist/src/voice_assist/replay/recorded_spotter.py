# SPDX-License-Identifier: BSD-3-Clause
"""A spotter in step with the pipeline that reports as late as the live one once did."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

from voice_assist.side_inputs import SideInputKind, SideInputs
from voice_assist.spotter.spotter import NEWEST, Spotted, Spotting
from voice_assist.types import Frame


class RecordedSpotter:
    """To a replay what SpotterThread is to the node, without a thread.

    It hears each frame at once, unless it is on record that the thread had not heard it yet.
    """

    def __init__(self, spotter: Spotting, past: SideInputs) -> None:
        """Start with a new stream.

        Args:
            spotter: Used by this alone.
            past: What happened to the live one.
        """
        self._spotter, self._past = spotter, past
        self._frames: deque[Frame] = deque()  # that it has not heard yet
        self._spotted: deque[tuple[int, Spotted]] = deque()
        self._heard_until = 0
        self._shown_until = NEWEST
        self._is_deaf = self._is_late = False

    def feed(self, frame: Frame) -> None:
        """Bring a frame; it is heard no later than when the pipeline hears it."""
        if self._past.get(SideInputKind.SPOTTER_DROPPED, frame.first_sample) is None:
            self._frames.append(frame)

    def __call__(self, frame: Frame) -> Spotted | None:
        """What was spotted up to that frame."""
        until = frame.next_sample
        failed = self._past.get(SideInputKind.SPOTTER_FAILED, frame.first_sample)
        late = failed or self._past.get(SideInputKind.SPOTTER_LATE, frame.first_sample)
        self._catch_up(min(late.heard_until, until) if late else until)
        self._is_deaf |= failed is not None
        self._shown_until = min(self._heard_until, until)
        self._is_late = late is not None
        if self._spotted and self._spotted[0][0] <= until:
            return self._spotted.popleft()[1]
        return None

    def best(self, since: float, until: int = NEWEST) -> float | None:
        """See Spotting."""
        if self._is_deaf or self._is_late:
            return None
        return self._spotter.best(since, min(until, self._shown_until))

    def reset(self) -> None:
        """Nothing, as with the thread."""

    def _catch_up(self, until: int) -> None:
        if self._is_deaf:
            return
        while self._frames and self._frames[0].first_sample < until:
            frame = self._frames.popleft()
            if spotted := self._spotter(frame):
                entry = replace(spotted, is_sent=True)
                self._spotted.append((frame.next_sample, entry))
            self._heard_until = frame.next_sample
