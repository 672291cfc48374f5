# SPDX-License-Identifier: BSD-3-Clause
"""A command on its way to a motion: the request, the situation, and the plan."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from rst_control.commands.spec import FURTHEST_PULL, TENSION_TARGET, CommandSpec
from rst_control.config import ControllerConfig
from rst_control.planning.plan import Grasp, Phase, PhaseKind
from rst_control.types import ControllerMode, Measurement, Vector

if TYPE_CHECKING:
    from rst_control.planning.insertion import Insertion
    from rst_control.planning.patient_surface import TrocarPose
    from rst_control.planning.planner import Planner
    from rst_control.trajectory.path import Path


@dataclass(frozen=True, eq=False)
class Request:
    """A command with its amounts.

    Raises:
        ValueError: The command does not take an amount, or not this one; names both.
    """

    command: CommandSpec
    tension: float = 0.0  # [N] target of "tense", step of the pulls; 0: as configured
    distance: float = 0.0  # [m] step of the pulls, or furthest pull of "tense"; 0: as configured

    def __post_init__(self) -> None:
        taken, phrase = {a.name: a for a in self.command.amounts}, self.command.phrase
        given = [a for a in (TENSION_TARGET, FURTHEST_PULL) if getattr(self, a.name) != 0.0]
        for amount in given:
            value, unit = getattr(self, amount.name), amount.unit
            if amount.name not in taken:
                words = f'"{phrase}" takes no {amount.name}, not {value:g} {unit}'
                raise ValueError(words)
            if not amount.allows(value):
                words = f"a number from {amount.minimum:g} {unit} up, not {value:g} {unit}"
                raise ValueError(f'the {amount.name} of "{phrase}" must be {words}')
        if len({taken[amount.name].meaning for amount in given}) < len(given):
            raise ValueError(f'"{phrase}" takes one step, not {self.amount}')

    @property
    def amount(self) -> str:
        """What was given with the command, such as "2 mm"; empty: as configured."""
        given = (f"{self.distance * 1e3:g} mm" if self.distance else "",)
        return ", ".join(filter(None, (f"{self.tension:g} N" if self.tension else "", *given)))


@dataclass(frozen=True, eq=False)
class Situation:
    """All that decides whether a command may run."""

    measurement: Measurement | None  # None: the robot has sent nothing yet
    now: float  # [s], same clock as the measurement
    setpoint: Vector | None = None  # (10,), [rad]; plans start there. None: at the measured joints
    mode: ControllerMode = field(default_factory=ControllerMode)
    grasp: Grasp | None = None
    pulled: float | None = None  # [m] of the tissue at the place of the grasp; None: as that says

    @property
    def is_moving(self) -> bool:
        """A motion or its braking is under way."""
        return self.mode.is_in_motion


@dataclass(frozen=True, eq=False)
class Plan:
    """A verified command: its phases in order, and what to remember once they are done.

    Without phases nothing moves but by the controller's own state: "hey robot", "stop",
    "terminate".
    """

    command: CommandSpec
    words: str  # what will be done, for people
    phases: tuple[Phase, ...] = ()
    grasp: Grasp | None = None  # to remember when this plan starts; None after "release"
    amount: str = ""  # given with the command, such as "2 mm"; empty: as configured

    @property
    def command_words(self) -> str:
        """The command with its amount, such as "pull more 2 mm"."""
        return f"{self.command.phrase} {self.amount}".rstrip()


@dataclass(frozen=True, eq=False)
class Accepted:
    """The command may run."""

    plan: Plan
    started: Callable[[], None] = lambda: None  # from the control loop, once the plan sets off


@dataclass(frozen=True, eq=False)
class PlanningContext:
    """All that the planner of a command gets."""

    planner: Planner
    insertion: Insertion
    request: Request
    situation: Situation
    measured: Measurement  # of a robot that is connected, up to date and healthy

    @property
    def config(self) -> ControllerConfig:
        """Settings of the controller."""
        return self.planner.config.controller

    @property
    def q(self) -> Vector:
        """Joints at which the plan starts [rad]. Shape (9,)."""
        from rst_control.kinematics.configuration import planning_joints

        setpoint = self.situation.setpoint
        joints = self.measured.position if setpoint is None else setpoint
        return planning_joints(np.asarray(joints))[0]

    @property
    def trocar_pose(self) -> TrocarPose:
        """Where tool and arm are, as measured."""
        from rst_control.kinematics.configuration import planning_joints

        return self.planner.patient.trocar_pose(planning_joints(self.measured.position)[0])

    def along(self, kind: PhaseKind, path: Path, speed: float) -> Phase:
        """Phase from one end of a path to the other, at up to `speed` [m/s]."""
        from rst_control.planning.planner import along

        return along(self.planner, kind, path, speed)

    def accept(self, words: str, phases: Sequence[Phase], grasp: Grasp | None = None) -> Accepted:
        """Accept the request with its plan."""
        request = self.request
        return Accepted(Plan(request.command, words, tuple(phases), grasp, request.amount))
