# SPDX-License-Identifier: BSD-3-Clause
"""A spotter in step with the pipeline that reports as late as the live one once did."""

from __future__ import annotations

from collections import deque

from voice_assist.side_inputs import SideInputKind, SideInputs
from voice_assist.spotter.spotter import Spotted, Spotting
from voice_assist.spotter.view import SpotterView
from voice_assist.types import Frame


class RecordedSpotter(SpotterView):
    """To a replay what SpotterThread is to the node, without a thread.

    It hears each frame at once, unless it is on record that the thread had not heard it yet.
    """

    def __init__(self, spotter: Spotting, past: SideInputs) -> None:
        """Start with a new stream.

        Args:
            spotter: Used by this alone.
            past: What happened to the live one.
        """
        super().__init__(spotter)
        self._past = past
        self._frames: deque[Frame] = deque()  # that it has not heard yet

    def feed(self, frame: Frame) -> None:
        """Bring a frame; it is heard no later than when the pipeline hears it."""
        if self._past.get(SideInputKind.SPOTTER_DROPPED, frame.first_sample) is None:
            self._frames.append(frame)

    def __call__(self, frame: Frame) -> Spotted | None:
        """What was spotted up to that frame."""
        failed = self._past.get(SideInputKind.SPOTTER_FAILED, frame.first_sample)
        late = failed or self._past.get(SideInputKind.SPOTTER_LATE, frame.first_sample)
        until = frame.next_sample
        self._catch_up(min(late.heard_until, until) if late else until)
        self._is_deaf |= failed is not None
        return self._show(frame, is_late=late is not None)

    def _catch_up(self, until: int) -> None:
        if self._is_deaf:
            return
        while self._frames and self._frames[0].first_sample < until:
            frame = self._frames.popleft()
            self._note_heard(frame, self._spotter(frame))
