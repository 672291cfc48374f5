# SPDX-License-Identifier: BSD-3-Clause
"""A command on its way to a motion: the request, the situation, and the plan or the refusal."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from rst_control.trajectory.path import Path
from rst_control.types import Cause, Command, Measurement, Vector


class PhaseKind(Enum):
    """Parts of a motion, as `ControllerState.phase` names them."""

    REACH = "reach"
    CLOSE = "close"
    PULL = "pull"
    STEP = "step"
    OPEN = "open"
    EASE = "ease"
    APPROACH = "approach"
    ALIGN = "align"
    INSERT = "insert"
    WITHDRAW = "withdraw"
    LOOK = "look"


@dataclass(frozen=True, eq=False)
class Phase:
    """One part of a motion: along a path, or the jaws while the tip stands still.

    A phase with a path goes from wherever the robot is on it to `target`; a phase without moves the
    jaws to `opening`. With a `tension` the target of s is a limit: the motion ends where the
    tension is reached, or there.
    """

    kind: PhaseKind
    path: Path | None = None  # None: the tip stands still
    start: float = 0.0  # [m], s at the start; ignored where the robot already is on the path
    target: float = 0.0  # [m], s at the end, or the furthest s when a tension is asked for
    speed: float = 0.0  # [m/s] of s, not to be exceeded
    acceleration: float = (
        0.0  # [m/s^2] of s, not to be exceeded: what the joints can do on this path
    )
    braking: float = 0.0  # [m/s^2] of s, hardest that a stop may be; 0: as `acceleration`
    opening: float | None = None  # [rad] of the jaws at the end; None: as it is
    tension: float | None = None  # [N] to reach and hold; None: none asked for

    @property
    def min_time(self) -> float:
        """Time that the way takes at the phase's speed [s]."""
        return abs(self.target - self.start) / self.speed if self.speed > 0.0 else 0.0


@dataclass(frozen=True, eq=False)
class Grasp:
    """What is remembered while tissue is held: the ways out and the pull so far."""

    pull: Path  # from the grasp point along the pull direction, over all its allowed range
    retreat: Path  # from the grasp point to clear of the tissue
    s: float = 0.0  # [m] on `pull`: target if moving, else where it stands
    tension: float | None = None  # [N] target; None: placed by distance


@dataclass(frozen=True, eq=False)
class Plan:
    """A verified command: its phases in order, and what to remember once they are done.

    Without phases nothing moves but by the controller's own state: "hey robot", "stop",
    "terminate".
    """

    command: Command
    words: str  # what will be done, for people
    phases: tuple[Phase, ...] = ()
    grasp: Grasp | None = None  # to remember when this plan starts; None after "release"


@dataclass(frozen=True, eq=False)
class Accepted:
    """The command may run."""

    plan: Plan


@dataclass(frozen=True)
class Rejected(Cause):
    """The command may not run."""


@dataclass(frozen=True, eq=False)
class Request:
    """A command with its parameters."""

    words: str  # as spoken
    tension: float = 0.0  # [N] target of "tense", step of the pulls; 0: as configured
    distance: float = 0.0  # [m] step of the pulls, or furthest pull of "tense"; 0: as configured


@dataclass(frozen=True, eq=False)
class Situation:
    """All that decides whether a command may run."""

    measurement: Measurement | None  # None: the robot never spoke
    now: float  # [s], same clock as the measurement
    setpoint: Vector | None = (
        None  # (10,), [rad]; plans start there. None: from the measured joints
    )
    is_active: bool = False
    is_moving: bool = False
    halt_reason: str = ""  # empty: not halted
    grasp: Grasp | None = None
