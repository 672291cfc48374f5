# SPDX-License-Identifier: BSD-3-Clause
"""What passes between the executor and those who give commands or publish its state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

from rst_control.commands.request import Plan, Situation
from rst_control.commands.spec import CommandSpec
from rst_control.planning.patient_surface import NOWHERE, TrocarPose
from rst_control.planning.plan import Grasp, PhaseKind
from rst_control.trajectory.path import Path
from rst_control.types import (
    NOT_CONNECTED,
    Cause,
    ControllerMode,
    Measurement,
    Reason,
    State,
    Vector,
)

DiaryKind = Literal[
    "accepted",
    "refused",
    "motion_started",
    "motion_finished",
    "stop_received",
    "at_rest",
    "halted",
    "cleared",
    "trocar_set",
    "trocar_refused",
]
OutcomeKind = Literal["succeeded", "refused", "stopped", "failed"]


@dataclass(frozen=True)
class Reply:
    """Answer to a command, in words for people."""

    accepted: bool
    message: str
    reason: Reason | None = None  # None: accepted

    def __post_init__(self) -> None:
        if self.accepted is not (self.reason is None):
            raise ValueError(f"accepted: {self.accepted}, with the reason {self.reason}")

    @classmethod
    def refused(cls, cause: Cause) -> Reply:
        """That the command is not carried out."""
        return cls(False, cause.words, cause.reason)


@dataclass(frozen=True)
class Outcome:
    """How a motion ended."""

    kind: OutcomeKind
    message: str  # why it did not succeed; empty: it did
    reason: Reason | None = None  # None: it succeeded
    tension: float = 0.0  # [N] at the end
    max_rcm_error: float = 0.0  # [m] largest measured in motion

    def __post_init__(self) -> None:
        if (self.kind == "succeeded") is not (self.reason is None):
            raise ValueError(f"outcome {self.kind} with the reason {self.reason}")


@dataclass(frozen=True)
class DiaryEntry:
    """Something that happened, for the timeline and the report."""

    stamp: float  # [s]
    kind: DiaryKind
    command: str
    message: str
    reason: Reason | None = None  # of what was refused, stopped, halted, given up or cleared


def _ignore(_: object) -> None:
    """Tell nobody."""


@dataclass(frozen=True, eq=False)
class Order:
    """A verified command on its way to the executor, with those who want to hear of it."""

    plan: Plan
    serial: int  # of the view in which it was verified
    is_spoken: bool = False  # it came from the voice node, whose heartbeat must go on
    owner: str = ""  # node whose loss brakes the motion; empty: it may leave
    reply: Callable[[Reply], None] = field(default=_ignore)
    stale: Callable[[], None] | None = (
        None  # instead of the reply, where the view has changed since
    )
    ended: Callable[[Outcome], None] = field(default=_ignore)

    @property
    def command(self) -> CommandSpec:
        """Which command it is."""
        return self.plan.command


@dataclass(frozen=True, slots=True)
class Glimpse:
    """How far a motion is."""

    phase: PhaseKind
    progress: float  # [0, 1] of the phase
    path_speed: float  # [m/s]


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class View:
    """The executor's state after one tick; never changes, so any thread may read it."""

    stamp: float  # [s]
    mode: ControllerMode
    serial: int  # changes whenever what verification looks at has changed, but for the measurement
    motion: Glimpse | None  # None: at rest
    plan: Plan | None  # under way; None: at rest
    path: Path | None  # where the tip is, or last was; None: on no path
    path_position: float  # [m] of the tip on it
    command: str  # in execution, or the last one
    trocar_pose: TrocarPose  # of the measured joints
    measurement: Measurement | None
    setpoint: Vector | None  # (10,), [rad]
    grasp: Grasp | None
    last_refusal: Cause | None  # None: none was refused
    health: Cause | None  # why the robot is not fit for a motion; None: it is

    @classmethod
    def at_start(cls) -> View:
        """Before the first tick."""
        return cls(
            stamp=0.0,
            mode=ControllerMode(),
            serial=0,
            motion=None,
            plan=None,
            path=None,
            path_position=0.0,
            command="",
            trocar_pose=NOWHERE,
            measurement=None,
            setpoint=None,
            grasp=None,
            last_refusal=None,
            health=NOT_CONNECTED,
        )

    @property
    def phase(self) -> str:
        """Of the motion, or "brake" or "hold"."""
        if self.motion is None:
            return "hold"
        return "brake" if self.mode.state is State.STOPPING else self.motion.phase.value

    @property
    def rcm_error(self) -> float:
        """Measured distance of the shaft's line from the trocar [m]; zero while none was measured.

        While the tool is outside the patient it only informs.
        """
        return 0.0 if self.measurement is None else self.trocar_pose.error

    @property
    def insertion(self) -> float:
        """Measured depth of the tip in the trocar [m], negative outside; zero while none was."""
        return 0.0 if self.measurement is None else self.trocar_pose.insertion

    @property
    def is_moving(self) -> bool:
        """A motion or its braking is under way."""
        return self.mode.is_in_motion

    @property
    def latch(self) -> Cause | None:
        """Why nothing moves until "hey robot", or will not once braked; None: no latch."""
        return self.mode.cause if self.mode.is_latched else None

    @property
    def is_tissue_held(self) -> bool:
        """The jaws are closed on tissue."""
        return self.measurement is not None and self.measurement.gripped

    @property
    def tension(self) -> float:
        """Measured pull of the tissue on the jaws [N]; zero while nothing was measured."""
        return self.measurement.tension if self.measurement else 0.0

    @property
    def tension_target(self) -> float:
        """Tension that the grasp is to have [N]; zero where none is set."""
        return (self.grasp.tension if self.grasp else None) or 0.0

    def situation(self, now: float) -> Situation:
        """All that verification needs to know."""
        return Situation(
            measurement=self.measurement,
            now=now,
            setpoint=self.setpoint,
            mode=self.mode,
            grasp=self.grasp,
        )


# Changes something between two ticks, or leaves it, in the view of that moment; what it did for the
# diary, None where it did nothing. It runs in the control loop, so it is quick and never raises.
Change = Callable[[View], DiaryEntry | None]
