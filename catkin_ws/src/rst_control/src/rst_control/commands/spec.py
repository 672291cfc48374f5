# SPDX-License-Identifier: BSD-3-Clause
"""All that is known of a command: when it counts, what it needs, what it does to the patient."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, ClassVar, Final

from rst_control.errors import Infeasible
from rst_control.planning.plan import PhaseKind
from rst_control.types import Reason, Rejected, State

if TYPE_CHECKING:
    from rst_control.commands.request import Accepted, PlanningContext

STOP: Final = "stop"  # the phrase that is taken from anybody, in any state


class LimitOfCommand(Infeasible):
    """A limit that one command alone has; its class gives the reason of the refusal."""

    reason: ClassVar[Reason] = Reason.UNREACHABLE


class Role(Enum):
    """What an accepted command does to the controller's mode."""

    ACTIVATE = "activate"  # clears a latch
    MOTION = "motion"
    STOP = "stop"  # brakes and latches
    TERMINATE = "terminate"  # brakes, then standby
    SET_UP = "set_up"  # nothing: what planning refers to is another at once


class Load(Enum):
    """What a motion does to the patient. Without a recording only what eases may begin."""

    LOADS = "loads"  # loads the patient more, or moves the tool within
    EASES = "eases"  # loads the patient less, or leaves
    NEITHER = "neither"  # the command moves nothing


class TissueNeeded(Enum):
    """What has to be between the jaws when a command is given."""

    HELD = "tissue held"
    NONE = "nothing held"
    ANY = "either"


class Place(Enum):
    """Where the tool has to be when a command is given."""

    INSIDE = "tool inserted"
    INSIDE_OR_HOLDING = "inserted or not"
    ANYWHERE = "anywhere"


@dataclass(frozen=True)
class Amount:
    """A number that a caller may give with a command; 0 stands for the configured one.

    In words it stands behind the command with a unit of `spoken_units`: "pull more 2 mm".
    """

    name: str  # field of the request and of the action's goal
    unit: str
    meaning: str
    minimum: float = 0.0  # in `unit`; the planner checks the largest against its settings

    @property
    def spoken_units(self) -> Mapping[str, float]:
        """Units of the amount in words, and how many of `unit` each is."""
        return {"mm": 1e-3, "m": 1.0} if self.unit == "m" else {self.unit: 1.0}

    def allows(self, value: float) -> bool:
        """Whether the value is a number within the bounds."""
        return math.isfinite(value) and value >= self.minimum


TENSION_TARGET: Final = Amount("tension", "N", "target")
TENSION_STEP: Final = Amount("tension", "N", "step")
FURTHEST_PULL: Final = Amount("distance", "m", "furthest pull")
DISTANCE_STEP: Final = Amount("distance", "m", "step")


@dataclass(frozen=True)
class CommandSpec:
    """One command, a row of the table `COMMANDS`."""

    phrase: str  # as spoken and sent, in lower case
    does: str  # what the robot does, for the documents
    role: Role = Role.MOTION
    counts_in: frozenset[State] = frozenset({State.ACTIVE})  # where it is not refused
    load: Load = Load.NEITHER
    tissue: TissueNeeded = TissueNeeded.ANY
    place: Place = Place.INSIDE
    phases: tuple[PhaseKind, ...] = ()  # kinds of phases that its plans are made of
    amounts: tuple[Amount, ...] = ()
    is_by_hand_only: bool = False  # refused from the voice node
    reply: str = ""  # when accepted; a motion's reply comes from its plan
    plan: Callable[[PlanningContext], Accepted | Rejected] | None = None  # None: nothing to plan

    def __hash__(self) -> int:
        return hash(self.phrase)
