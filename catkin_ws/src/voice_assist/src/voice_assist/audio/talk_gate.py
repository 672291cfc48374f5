# SPDX-License-Identifier: BSD-3-Clause
"""Push-to-talk: whether speech was said while voice counted."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Final

LATE_PRESS: Final = 0.3  # [s] of speech before the press that is no fault: endpointing pads
EARLY_RELEASE: Final = 0.2  # [s] of speech after the release, likewise
KEPT: Final = 50  # changes
SET_BACK: Final = 10.0  # [s] after speech in which no change is known yet but to another clock


@dataclass(frozen=True)
class TalkChange:
    """From now on voice counts, or does not."""

    is_open: bool
    time: float  # [s] clock time at which it was reported


class TalkGate:
    """Follows the gate; without any news of one, voice counts."""

    def __init__(self) -> None:
        self._changes: deque[TalkChange] = deque(maxlen=KEPT)

    def update(self, change: TalkChange) -> None:
        """Follow; where the clock was set back, what was before counts as long ago."""
        if self._changes and change.time < self._changes[-1].time:
            stood = self._changes[-1].is_open
            self._changes.clear()
            self._changes.append(TalkChange(stood, float("-inf")))
        if not self._changes or self._changes[-1].is_open != change.is_open:
            self._changes.append(change)

    def reset(self) -> None:
        """Keep only how it stands."""
        while len(self._changes) > 1:
            self._changes.popleft()

    def was_open(self, start: float, end: float) -> bool:
        """Whether voice counted over all of what was said from `start` to `end` [s]."""
        if not self._changes:
            return True
        if self._changes[-1].time > end + SET_BACK:
            return self._changes[-1].is_open
        start, end = min(start + LATE_PRESS, end), max(start, end - EARLY_RELEASE)
        is_open = self._changes[0].is_open  # as if it had stood so before
        for change in self._changes:
            if change.time > start:
                break
            is_open = change.is_open
        if not is_open:
            return False
        return all(c.is_open for c in self._changes if start < c.time <= end)
