# SPDX-License-Identifier: BSD-3-Clause
"""What the triangulation demonstration says, and what the tissue did."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from paper.judging.recording import VERDICT, Recorded
from paper.judging.trials import SpokenTrial
from paper.play.plan import (
    HEY_ROBOT,
    PULL_LESS,
    PULL_MORE,
    RELEASE,
    STOP,
    TENSE,
    TERMINATE,
    DialogueState,
    Planned,
)

ORDER = (HEY_ROBOT, TENSE, PULL_MORE, PULL_LESS, RELEASE, STOP, TERMINATE)
STOP_IN = "ease"  # phase of the release that "stop" interrupts
ATTEMPTS = 4  # at each command, before the demonstration is given up
LEAST_CHANGE = 0.05  # [N] of tension that counts as more or less


class InOrder:
    """Asks for one command after the other, and again for one that had no effect."""

    def __init__(self) -> None:
        self._at, self._attempts, self._is_stop_said = -1, 0, False
        self._before = DialogueState(False, False, False, False)

    @property
    def left(self) -> int:
        """Number of commands still to come."""
        return len(ORDER) - 1 - max(self._at, 0)

    def next(self, situation: DialogueState) -> Planned | None:
        """Return the next command of the order, or the last one again."""
        if self._at < 0 or self._has_happened(situation):
            self._at, self._attempts, self._before = self._at + 1, 0, situation
            if self._at < len(ORDER) and ORDER[self._at] == STOP and self._is_stop_said:
                self._at += situation.is_halted  # it was said, and heard, in the motion
        self._attempts += 1
        if self._at >= len(ORDER) or self._attempts > ATTEMPTS:
            return None
        command = ORDER[self._at]
        return Planned(command, command, STOP_IN if command == RELEASE else "")

    def interrupt(self) -> Planned:
        """Say "stop" in the release."""
        self._is_stop_said = True
        return Planned(STOP, STOP)

    def _has_happened(self, now: DialogueState) -> bool:
        change = now.tension - self._before.tension
        return {
            HEY_ROBOT: now.is_active and now.is_listening and not now.is_halted,
            TENSE: now.is_held,
            PULL_MORE: change > LEAST_CHANGE,
            PULL_LESS: change < -LEAST_CHANGE,
            RELEASE: not now.is_held,
            STOP: now.is_halted,
            TERMINATE: not now.is_active,
        }[ORDER[self._at]]


@dataclass(frozen=True)
class Shown:
    """The tissue after one command, in the simulator's own words and numbers."""

    command: str
    tissue: dict[str, str]  # verdict, and where the jaws hold it angle, strain and so on


def shown(trials: Sequence[SpokenTrial], recorded: Recorded) -> list[Shown]:
    """How the tissue was held at rest after each command of the demonstration."""
    found = []
    for i, trial in enumerate(trials):
        later = trials[i + 1 :]
        until = later[0].began if later else float("inf")
        said = [status for time_, status in recorded.tissue if trial.ended < time_ < until]
        found.append(Shown(trial.command, said[-1] if said else {VERDICT: "unknown"}))
    return found
