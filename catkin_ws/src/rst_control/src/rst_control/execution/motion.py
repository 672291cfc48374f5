# SPDX-License-Identifier: BSD-3-Clause
"""A plan under way: its phases one after the other, each starting where the last one ended."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from rst_control.commands.request import Plan
from rst_control.commands.spec import Load
from rst_control.config import ControllerConfig
from rst_control.errors import RstError
from rst_control.execution.guarded_pull import GuardedPull
from rst_control.execution.phase_execution import (
    JawPhase,
    PathPhase,
    PhaseExecution,
    PhaseStart,
    TensionPhase,
)
from rst_control.kinematics.configuration import planning_joints
from rst_control.planning.plan import Grasp, Phase, PhaseKind
from rst_control.tension.grasp_response import GraspResponse
from rst_control.trajectory.motion_profile import MotionBounds
from rst_control.trajectory.path import Path
from rst_control.types import Cause, Measurement, PathState, Reason, Rejected, Vector

START_TOLERANCE = 1e-5  # [rad] between a joint's set-point and where a phase begins
PULLS = (PhaseKind.PULL, PhaseKind.STEP)


class OffPath(RstError):
    """A phase would begin away from where the robot stands."""

    def __init__(self, phase: PhaseKind, distance: float) -> None:
        super().__init__(
            f"{phase.value} would begin {distance:.6f} rad away from where the robot stands, "
            f"allowed {START_TOLERANCE:.6f} rad"
        )
        self.distance = distance


@dataclass(frozen=True, slots=True)
class MotionProgress:
    """How far a motion is."""

    phase: PhaseKind
    progress: float  # [0, 1] of the phase
    path_speed: float  # [m/s]


@dataclass(frozen=True, eq=False)
class PathPosition:
    """Where on which path the tip is."""

    path: Path
    state: PathState


class Motion:
    """Carries out a plan; made by `MotionMaker`.

    Args:
        maker: Makes the phases.
        plan: With at least one phase.
        held: Set-point at the start [rad]. Shape (10,).
        place: Where the tip is, if on a path.
        now: Time [s].
    """

    def __init__(
        self, maker: MotionMaker, plan: Plan, held: Vector, place: PathPosition | None, now: float
    ) -> None:
        self.plan = plan
        self._maker, self._held, self._place = maker, held, place
        self._waiting = deque(plan.phases)
        self._is_braking = False
        self._run = self._start_next_phase(now)

    def advance(self, periods: int, measured: Measurement, now: float) -> tuple[Vector, Vector]:
        """Move on.

        Args:
            periods: Of the control loop since the last call.
            measured: Newest from the robot.
            now: Time [s].

        Returns:
            Joints [rad] and their velocities [rad/s], each of shape (10,).

        Raises:
            OffPath: The next phase would begin elsewhere.
        """
        if self._run.is_done and self._waiting and not self._is_braking:
            self._run = self._start_next_phase(now)
        self._held, velocity = self._run.step(periods * self._maker.period, measured)
        if self._run.phase.path is not None:
            self._place = PathPosition(self._run.phase.path, self._run.state)
        return self._held, velocity

    def brake(self) -> None:
        """Come to rest along the path as soon as the limits allow; the rest is dropped."""
        self._is_braking = True
        self._run.brake()

    @property
    def is_done(self) -> bool:
        """It came to rest: at the end of the plan, or after braking."""
        return self._run.is_done and (not self._waiting or self._is_braking)

    @property
    def failure(self) -> Cause | None:
        """Why the plan cannot go on; None: it can."""
        return self._run.failure

    def overtime(self, now: float) -> float:
        """Age of the present phase beyond the time that its way takes at its speed [s]."""
        return now - self.phase_start - self._run.phase.min_time

    @property
    def phase(self) -> PhaseKind:
        """The phase under way."""
        return self._run.phase.kind

    @property
    def place(self) -> PathPosition | None:
        """Where the tip is, if on a path."""
        return self._place

    @property
    def progress(self) -> MotionProgress:
        """How far it is."""
        speed = self._place.state.speed if self._place else 0.0
        return MotionProgress(self.phase, self._run.progress, speed)

    @property
    def raises_tension(self) -> bool:
        """The phase may pull on tissue."""
        return self._run.is_pulling or self.phase in (PhaseKind.REACH, PhaseKind.CLOSE)

    @property
    def needs_grip(self) -> bool:
        """The phase pulls on tissue that must be held."""
        return self.phase in PULLS and not self._is_braking

    @property
    def only_opens(self) -> bool:
        """The jaws open and the arm stands still, in the next tick as well."""
        return self.phase is PhaseKind.OPEN and not self._run.is_done

    @property
    def easing_since(self) -> float | None:
        """When the phase began [s], if the command eases the load; None: it does not."""
        return self.phase_start if self.plan.command.load is Load.EASES else None

    @property
    def can_retarget(self) -> bool:
        """Another pull may take over from here, at the present speed."""
        return self.phase in PULLS and not self._is_braking and not self._waiting

    def grasp_after(self, grasp: Grasp | None) -> Grasp | None:
        """What to remember of the grasp now that the motion came to rest."""
        if grasp is None or self._place is None:
            return grasp
        tension = None if self._is_braking else grasp.tension
        if self._place.path is grasp.pull:
            return replace(grasp, s=self._place.state.s, tension=tension)
        if not self._is_braking:
            return grasp
        still_to_pull = (phase.start for phase in self._waiting if phase.path is grasp.pull)
        return replace(grasp, s=next(still_to_pull, 0.0), tension=None)

    def _start_next_phase(self, now: float) -> PhaseExecution:
        phase = self._waiting.popleft()
        self.phase_start = now
        return self._maker.start_phase(phase, self._held, self._place)


class MotionMaker:
    """Makes motions of verified plans.

    Args:
        config: Speeds and forces.
        response: Of the tissue held; None: of one that is never asked for.
    """

    def __init__(self, config: ControllerConfig, response: GraspResponse | None = None) -> None:
        deficit = config.watchdogs.sensors.tension_deficit
        self._response = response or GraspResponse(config.tension, deficit)
        self.period = 1.0 / config.rate
        self._jerk, self._tension = config.speed.jerk, config.tension
        self._braking_jerk = config.speed.braking_jerk
        self._settle = config.jaws.settle_time
        jaws, scale = config.jaws, config.speed.scale
        self._jaws = MotionBounds(jaws.speed * scale, jaws.acceleration, jaws.jerk)
        self._jaw_brakes = MotionBounds(jaws.speed, jaws.braking, jaws.braking_jerk)

    def make(
        self,
        plan: Plan,
        held: Vector,
        running: Motion | None,
        place: PathPosition | None,
        now: float,
    ) -> Motion | Rejected:
        """Start a plan from rest, or let it take over from a pull that still moves."""
        if running is not None:
            is_same = plan.phases[0].path is (running.place.path if running.place else None)
            if not (running.can_retarget and is_same):
                return Rejected(Reason.BUSY, f"busy: {running.phase.value}")
            place = running.place
        try:
            return Motion(self, plan, held, place, now)
        except OffPath as error:
            return Rejected(Reason.NOT_AT_REST, str(error))

    def start_phase(self, phase: Phase, held: Vector, place: PathPosition | None) -> PhaseExecution:
        """Start one phase.

        Raises:
            OffPath: It would begin elsewhere.
        """
        path = phase.path
        if path is None:
            settle = 0.0 if phase.kind is PhaseKind.OPEN else self._settle
            return JawPhase(phase, held, self._jaws, self._jaw_brakes, settle)
        state = PathState(phase.start)
        if place is not None and place.path is path:
            state = place.state
        q, opening = planning_joints(held)
        _require_near(phase, q, path.evaluate(state.s).q)
        bounds = MotionBounds(phase.speed, phase.acceleration, self._jerk)
        brakes = bounds
        if phase.braking > 0.0:
            brakes = MotionBounds(phase.speed, phase.braking, self._braking_jerk)
        start = PhaseStart(phase, path, state, opening, bounds, brakes)
        if phase.tension is None:
            return PathPhase(start)
        run = GuardedPull if self._tension.source == "joint_torque" else TensionPhase
        return run(start, self._tension, self._response)


def _require_near(phase: Phase, q: Vector, start: Vector) -> None:
    distance = float(np.abs(q - start).max())
    if not distance <= START_TOLERANCE:
        raise OffPath(phase.kind, distance)
