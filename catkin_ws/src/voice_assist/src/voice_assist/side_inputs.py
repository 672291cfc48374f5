# SPDX-License-Identifier: BSD-3-Clause
"""Inputs of hearing other than sound: how late it was, and what controller and people reported.

On a machine that keeps up, nothing is late: every decision follows from the sound and the reports.
Where it does not keep up, the node says so here, frame by frame. Recorded with the sound, this lets
a replay decide as was decided then.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from enum import Enum

from voice_assist.types import Mode


class SideInputKind(Enum):
    """What happened at a frame."""

    HEARD = "heard"  # every second or so: all before this frame was heard and decided on
    ANSWERED = "answered"  # the controller answered before this frame was heard
    ASKED = "asked"  # before it, people were shown a question
    BY_HAND = "by hand"  # before it, a person answered a question by hand
    ROBOT_MODE = "robot mode"  # before it, the robot was found in another mode than the voice
    SPEAKING = "speaking"  # before it, the robot's own speech began or ended
    TALK = "talk"  # before it, a pedal let voice count, or not
    MOVING = "moving"  # from it on the robot moves, or rests
    BEHIND = "behind"  # it was heard too late to be decoded before the end of the utterance
    UNHEARD = "unheard"  # the recogniser's queue was full: only the spotter heard it
    LOST = "lost"  # sound is missing in front of it, already when it was captured
    SPOTTER_LATE = "spotter late"  # the spotter had not heard it yet, only up to `heard_until`
    SPOTTER_DROPPED = "spotter dropped"  # the spotter's queue was full: it never heard it
    SPOTTER_FAILED = "spotter failed"  # from it on the recogniser alone listened


REPORTED = (  # by others, between two frames
    SideInputKind.ANSWERED,
    SideInputKind.ASKED,
    SideInputKind.BY_HAND,
    SideInputKind.ROBOT_MODE,
    SideInputKind.SPEAKING,
    SideInputKind.TALK,
)


@dataclass(frozen=True)
class SideInput:
    """One thing that happened at one frame."""

    kind: SideInputKind
    sample: int  # first sample of the frame
    heard_until: int = 0  # sample up to which the spotter had heard; of SPOTTER_LATE and _FAILED
    command: str = ""  # of ANSWERED, as are the next two; of BY_HAND, as is the next
    is_accepted: bool = False
    message: str = ""
    is_speaking: bool = False  # of SPEAKING, as is the next, which is also of TALK
    time: float = 0.0  # [s] clock time at which it was reported
    is_open: bool = False  # of TALK
    is_moving: bool = False  # of MOVING
    mode: str = ""  # of ROBOT_MODE


Observer = Callable[[SideInput], None]


def ignore(_: SideInput) -> None:
    """An observer that keeps nothing."""


def to_text(side_input: SideInput) -> str:
    """One line of JSON."""
    return json.dumps({**asdict(side_input), "kind": side_input.kind.value})


def from_text(line: str) -> SideInput:
    """What `to_text` wrote.

    Raises:
        ValueError: The line is something else.
    """
    try:
        fields = json.loads(line)
        found = SideInput(**{**fields, "kind": SideInputKind(fields["kind"])})
        if found.kind is SideInputKind.ROBOT_MODE:
            Mode(found.mode)
        return found
    except (TypeError, KeyError, ValueError) as error:
        raise ValueError(f"{line!r} is no side input of the pipeline: {error}") from error


class SideInputs:
    """Those of one stream, found by frame."""

    def __init__(self, all_of_them: Iterable[SideInput]) -> None:
        """Keep them; the order matters among what others reported only."""
        kept = tuple(all_of_them)
        self._found = {(entry.kind, entry.sample): entry for entry in kept}
        self._reported = [entry for entry in kept if entry.kind in REPORTED]
        heard = [entry.sample for entry in kept if entry.kind is SideInputKind.HEARD]
        self._moving = [entry for entry in kept if entry.kind is SideInputKind.MOVING]
        self._is_moving = False
        self.heard_until = max(heard, default=0)  # sample before which all was surely decided on

    def get(self, kind: SideInputKind, sample: int) -> SideInput | None:
        """That of a kind at a frame, if there was one."""
        return self._found.get((kind, sample))

    def take_reported(self, sample: int) -> list[SideInput]:
        """What others reported before the frame, each once, oldest first."""
        due = [entry for entry in self._reported if entry.sample <= sample]
        self._reported = self._reported[len(due) :]
        return due

    def is_moving(self, sample: int) -> bool:
        """Whether the robot moved at the frame, as noted then; asked frame by frame, in order."""
        while self._moving and self._moving[0].sample <= sample:
            self._is_moving = self._moving.pop(0).is_moving
        return self._is_moving
