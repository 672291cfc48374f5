# SPDX-License-Identifier: BSD-3-Clause
"""What hearing depended on besides the sound: how late it was, and what the controller answered.

On a machine that keeps up nothing of this happens but progress and answers, and every decision is a
function of the sound alone. Where it does not keep up, the node says so here, frame by frame;
recorded with the sound, it lets a replay decide as was decided then.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from enum import Enum


class Kind(Enum):
    """What happened at a frame."""

    HEARD = "heard"  # every second or so: all before this frame was heard and decided on
    ANSWERED = "answered"  # the controller answered before this frame was heard
    SPEAKING = "speaking"  # before it, the robot's own speech was told to begin or to end
    BEHIND = "behind"  # it was heard too late for a look before the end of the utterance
    UNHEARD = "unheard"  # the recogniser's queue was full: only the spotter heard it
    LOST = "lost"  # sound is missing in front of it, already when it was captured
    SPOTTER_LATE = "spotter late"  # the spotter had not heard it yet, only up to `heard_until`
    SPOTTER_DROPPED = "spotter dropped"  # the spotter's queue was full: it never heard it
    SPOTTER_FAILED = "spotter failed"  # from it on nobody but the recogniser listened


TOLD = (Kind.ANSWERED, Kind.SPEAKING)  # by others, between two frames


@dataclass(frozen=True)
class Circumstance:
    """One thing that happened at one frame."""

    kind: Kind
    sample: int  # first sample of the frame
    heard_until: int = 0  # sample up to which the spotter had heard; of SPOTTER_LATE and _FAILED
    command: str = ""  # of ANSWERED, as are the next two
    is_accepted: bool = False
    message: str = ""
    is_speaking: bool = False  # of SPEAKING, as is the next
    time: float = 0.0  # [s] clock time at which it was told


Witness = Callable[[Circumstance], None]


def ignore(_: Circumstance) -> None:
    """A witness that keeps nothing."""


def to_text(circumstance: Circumstance) -> str:
    """One line of JSON."""
    return json.dumps({**asdict(circumstance), "kind": circumstance.kind.value})


def from_text(line: str) -> Circumstance:
    """What `to_text` wrote.

    Raises:
        ValueError: The line is something else.
    """
    try:
        fields = json.loads(line)
        return Circumstance(**{**fields, "kind": Kind(fields["kind"])})
    except (TypeError, KeyError, ValueError) as error:
        raise ValueError(f"{line!r} is no circumstance of hearing: {error}") from error


class Circumstances:
    """Those of one stream, found by frame."""

    def __init__(self, all_of_them: Iterable[Circumstance]) -> None:
        """Keep them; the order matters among what was told only."""
        kept = tuple(all_of_them)
        self._found = {(entry.kind, entry.sample): entry for entry in kept}
        self._told = [entry for entry in kept if entry.kind in TOLD]
        heard = [entry.sample for entry in kept if entry.kind is Kind.HEARD]
        self.heard_until = max(heard, default=0)  # sample before which all was surely decided on

    def get(self, kind: Kind, sample: int) -> Circumstance | None:
        """That of a kind at a frame, if there was one."""
        return self._found.get((kind, sample))

    def take_told(self, sample: int) -> list[Circumstance]:
        """What was told before the frame, each once, oldest first."""
        due = [entry for entry in self._told if entry.sample <= sample]
        self._told = self._told[len(due) :]
        return due
