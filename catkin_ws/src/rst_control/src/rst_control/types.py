# SPDX-License-Identifier: BSD-3-Clause
"""Values that the stages exchange: frozen, arrays copied and read-only."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from rst_control.path import Path

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

ARM_JOINTS = tuple(f"joint_{i}" for i in range(1, 8))
JOINTS = (*ARM_JOINTS, "joint_pitch", "joint_finger_left", "joint_finger_right")
JOINT_COUNT = len(JOINTS)  # of the robot
PLAN_COUNT = 9  # of a planning configuration q: joint_1 .. joint_7, pitch, yaw


def frozen_array(values: ArrayLike, *shape: int) -> Vector:
    """Copy to a read-only float array.

    Raises:
        ValueError: The shape is another, or a value is not finite.
    """
    array = np.array(values, dtype=np.float64)
    if array.shape != shape:
        raise ValueError(f"array of shape {array.shape}, allowed: {shape}")
    if not all(map(math.isfinite, array.ravel().tolist())):  # of few numbers faster than by numpy
        raise ValueError("array with values that are not finite")
    array.flags.writeable = False
    return array


@dataclass(frozen=True, eq=False, slots=True)
class Measurement:
    """What the robot side last said."""

    position: Vector  # (10,), [rad], order of JOINTS
    velocity: Vector  # (10,), [rad/s]
    effort: Vector  # (10,), [N m]
    stamp: float  # [s] steady clock, when it arrived
    force: Vector = field(default_factory=lambda: np.zeros(3))  # (3,), [N], of tissue on jaws, base
    gripped: bool = False  # tissue lies between the closed jaws
    connected: bool = True
    fault: str = ""  # empty: healthy
    distrust: str = ""  # why the force must not be relied on; empty: it may
    sent: float | None = None  # [s] sender's clock, which may be set at any time; None: not told
    sent_to: Vector | None = None  # (10,), [rad], where it holds while nobody leads; None: not told

    def __post_init__(self) -> None:
        for name in ("position", "velocity", "effort"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), JOINT_COUNT))
        object.__setattr__(self, "force", frozen_array(self.force, 3))

    @property
    def tension(self) -> float:
        """Pull of the tissue on the jaws [N]."""
        x, y, z = self.force.tolist()
        return float((x * x + y * y + z * z) ** 0.5)


@dataclass(frozen=True, eq=False, slots=True)
class Setpoint:
    """Where the joints should be at a time."""

    position: Vector  # (10,), [rad], order of JOINTS
    velocity: Vector  # (10,), [rad/s]
    stamp: float  # [s]

    def __post_init__(self) -> None:
        for name in ("position", "velocity"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), JOINT_COUNT))


@dataclass(frozen=True, slots=True)
class PathState:
    """Where on a path, how fast, how much faster."""

    s: float  # [m]
    speed: float = 0.0  # [m/s]
    acceleration: float = 0.0  # [m/s^2]


class Command(Enum):
    """What a person may ask for; the value is the spoken phrase."""

    HEY_ROBOT = "hey robot"
    TENSE = "tense"
    RELEASE = "release"
    PULL_MORE = "pull more"
    PULL_LESS = "pull less"
    STOP = "stop"
    TERMINATE = "terminate"
    INSERT = "insert"
    WITHDRAW = "withdraw"
    LOOK_LEFT = "look left"
    LOOK_RIGHT = "look right"
    LOOK_UP = "look up"
    LOOK_DOWN = "look down"
    LOOK_UP_LEFT = "look up left"
    LOOK_UP_RIGHT = "look up right"
    LOOK_DOWN_LEFT = "look down left"
    LOOK_DOWN_RIGHT = "look down right"
    LOOK_CLOSER = "look closer"
    LOOK_WIDER = "look wider"


BY_HAND = (Command.INSERT, Command.WITHDRAW)  # never by voice
LOOKS = tuple(command for command in Command if command.value.startswith("look "))


class Reason(Enum):
    """Why a command is refused; the value is for logs, the words of `Rejected` are for people."""

    UNKNOWN_COMMAND = "unknown command"
    WRONG_MODE = "wrong mode"
    HALTED = "halted"
    BUSY = "busy"
    NOT_AT_REST = "not at rest"
    NOTHING_GRASPED = "nothing grasped"
    ALREADY_GRASPED = "already grasped"
    ALREADY_THERE = "already there"
    NOT_INSERTED = "not inserted"
    UNREACHABLE = "unreachable"
    JOINT_LIMIT = "joint limit"
    RCM_TOLERANCE = "rcm tolerance"
    WORKSPACE = "workspace"
    INSERTION_DEPTH = "insertion depth"
    COLLISION = "collision"
    SINGULAR = "near singular"
    TENSION_LIMIT = "tension limit"
    DISPLACEMENT_LIMIT = "displacement limit"
    TILT_LIMIT = "tilt limit"
    NOT_CONNECTED = "not connected"
    FAULTED = "faulted"
    STALE = "joint states stale"
    NOT_RECORDED = "not recorded"
    NOT_CONFIRMED = "not confirmed"


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
    def least_time(self) -> float:
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
class Rejected:
    """The command may not run."""

    reason: Reason
    words: str  # names the value and what was allowed


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
