# SPDX-License-Identifier: BSD-3-Clause
"""Carries out one phase of a plan tick by tick: along a path, to a tension, or with the jaws alone.

All can brake at any tick. Braking begins at once: an acceleration that still pushes on is cut,
not faded out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from rst_control.config import TensionConfig
from rst_control.kinematics.configuration import planning_joints, robot_joints
from rst_control.planning.plan import Phase, PhaseKind
from rst_control.tension.control import TensionControl
from rst_control.tension.grasp_response import GraspResponse
from rst_control.trajectory.motion_profile import MotionBounds, MotionProfile
from rst_control.trajectory.path import Path
from rst_control.types import PLAN_COUNT, Cause, Measurement, PathState, Reason, Vector

TINY = 1e-9  # [m] or [rad] of way, below which a phase has none to go


class PhaseExecution(Protocol):
    """One phase under way."""

    phase: Phase
    is_done: bool  # at its end, or at rest after braking
    failure: Cause | None  # why it could not reach its end; None: it did, or is under way
    is_pulling: bool  # it may raise the tension

    def step(self, dt: float, measured: Measurement) -> tuple[Vector, Vector]:
        """Move on by a time [s].

        Returns:
            Joints [rad] and their velocities [rad/s], each of shape (10,).
        """
        ...

    def brake(self) -> None:
        """Come to rest as soon as the limits allow."""
        ...

    @property
    def state(self) -> PathState:
        """Where on the path it is; of the jaws' motion, the tip's: at rest."""
        ...

    @property
    def progress(self) -> float:
        """Share of the phase that is done, from 0 to 1."""
        ...


@dataclass(frozen=True, eq=False)
class PhaseStart:
    """How a phase along a path begins, and how it may move there."""

    phase: Phase
    path: Path  # that of the phase
    state: PathState  # where on the path, and how fast
    opening: float  # [rad] of the jaws, which stays
    bounds: MotionBounds  # of the motion along the path
    brakes: MotionBounds  # of a stop

    @property
    def furthest(self) -> float:
        """Furthest s that a pull may go to [m]; one that is beyond is not taken back."""
        return max(self.phase.target, self.state.s)


class Course(Protocol):
    """Motion of s along a path."""

    @property
    def state(self) -> PathState:
        """Where s is now."""
        ...


class AlongPath:
    """What the phases along a path share: where they are, and how they come to rest.

    Args:
        start: How it begins.
        course: Of s, unless it brakes.
    """

    def __init__(self, start: PhaseStart, course: Course) -> None:
        self.phase, self._start, self._course = start.phase, start, course
        self.is_done, self.is_pulling = False, False
        self.failure: Cause | None = None
        self._brake: MotionProfile | None = None

    @property
    def state(self) -> PathState:
        """Where on the path it is."""
        return (self._brake or self._course).state

    def brake(self) -> None:
        """Come to rest as soon as the limits allow."""
        self._brake_from(self.state)

    def _brake_from(self, state: PathState) -> None:
        if self._brake is None:
            self.is_pulling = False
            self._brake = MotionProfile.braking(state, self._start.brakes)

    def _joints(self, state: PathState) -> tuple[Vector, Vector]:
        point = self._start.path.evaluate(state.s)
        joints = robot_joints(point.q, self._start.opening)
        return joints, robot_joints(point.dq * state.speed, 0.0)


class PathPhase(AlongPath):
    """Goes along a path to the target of the phase."""

    def __init__(self, start: PhaseStart) -> None:
        self._profile = MotionProfile(start.state, start.bounds)
        super().__init__(start, self._profile)
        self.is_pulling = self.phase.target > start.state.s
        self._profile.go_to(self.phase.target)

    def step(self, dt: float, measured: Measurement) -> tuple[Vector, Vector]:
        """Move on by a time [s]; see `PhaseExecution`."""
        profile = self._brake or self._profile
        state = profile.step(dt)
        self.is_done = profile.is_done
        return self._joints(state)

    @property
    def progress(self) -> float:
        """Share of the way that is done, from 0 to 1."""
        return share_done(self._start.state.s, self.state.s, self.phase.target)


class TowardsTension(AlongPath):
    """What the ways of going along a path to a tension share: where they began, and how far on.

    Args:
        start: How it begins; its phase has a tension.
        course: Of s, unless it brakes.
        response: Of the tissue held.
    """

    def __init__(self, start: PhaseStart, course: Course, response: GraspResponse) -> None:
        super().__init__(start, course)
        self._response = response
        self._goal = start.phase.tension or 0.0
        self._first: float | None = None  # [N] when it began
        self._now = 0.0
        self._furthest = start.furthest
        self._stamp, self._allowed = -np.inf, start.state.s

    @property
    def progress(self) -> float:
        """Share of the change of tension, or of the way to the furthest s, that is done."""
        if self._first is None:
            return 0.0
        way = share_done(self._start.state.s, self.state.s, self._furthest)
        return max(way, share_done(self._first, self._now, self._goal))

    def _feel(self, tension: float) -> bool:
        """Note the present tension [N]; whether it is the first one."""
        is_first, self._now = self._first is None, tension
        if is_first:
            self._first = tension
        return is_first

    def _room_ends(self, measured: Measurement) -> float:
        """Place [m] that s may not pass before a reading at rest allows more.

        The response counts from where s was at its newest reading; readings may be seldom.
        """
        if measured.stamp != self._stamp:
            self._stamp, self._allowed = measured.stamp, self.state.s + self._response.room
        return self._allowed

    def _objection(self, measured: Measurement) -> Cause | None:
        """Why the tension is no reason to go on; None: nothing speaks against it."""
        return self._response.objection or tension_invalid(measured)


class TensionPhase(TowardsTension):
    """Pulls or eases along a path to the tension of the phase, or to the furthest s.

    It fails where the tension does not rise with the pull.

    Args:
        start: How it begins; its phase has a tension.
        config: Of the tension control.
        response: Of the tissue held.
    """

    def __init__(self, start: PhaseStart, config: TensionConfig, response: GraspResponse) -> None:
        goal = start.phase.tension or 0.0
        self._control = TensionControl(
            config, start.bounds, start.brakes, start.furthest, start.state, goal
        )
        super().__init__(start, self._control, response)

    def step(self, dt: float, measured: Measurement) -> tuple[Vector, Vector]:
        """Move on by a time [s]; see `PhaseExecution`."""
        self._feel(measured.tension)
        if self._brake is not None:
            state = self._brake.step(dt)
            self.is_done = self._brake.is_done
            return self._joints(state)
        self._control.bound = self._room_ends(measured)
        state = self._control.step(self._now, dt)
        self.is_pulling = self._control.is_pulling
        self.failure = self._objection(measured)
        if self.failure or self._control.is_settled or self._control.is_at_limit:
            self._brake_from(state)
        return self._joints(state)


class JawPhase:
    """Moves the jaws while the tip stands still, and waits until they have settled.

    Args:
        phase: With an opening.
        held: Joints where it starts [rad]. Shape (10,).
        bounds: Of the opening.
        brakes: The same while braking.
        settle_time: After the jaws came to rest [s].
    """

    is_pulling = False

    def __init__(
        self,
        phase: Phase,
        held: Vector,
        bounds: MotionBounds,
        brakes: MotionBounds,
        settle_time: float,
    ) -> None:
        self.is_done = False
        self.failure: Cause | None = None
        self._q, self._start = planning_joints(held)
        self._target = self._start if phase.opening is None else phase.opening
        self._brakes, self._left = brakes, settle_time
        self._is_braking = False
        self._profile = MotionProfile(PathState(self._start), bounds)
        self._profile.go_to(self._target)
        self.phase = replace(phase, jaw_time=self._profile.remaining + settle_time)

    @property
    def state(self) -> PathState:
        """The tip stands still; its place on a path is known to its caller."""
        return PathState(0.0)

    def step(self, dt: float, measured: Measurement) -> tuple[Vector, Vector]:
        """Move on by a time [s]; see `PhaseExecution`."""
        opening = self._profile.step(dt)
        if self._profile.is_done:
            self._left -= dt
            self.is_done = self._is_braking or self._left <= 0.0
            if self.is_done and not self._is_braking:
                self.failure = _grip_failure(self.phase.kind, measured.gripped)
        still = np.zeros(PLAN_COUNT)
        return robot_joints(self._q, opening.s), robot_joints(still, opening.speed)

    def brake(self) -> None:
        """Let the jaws come to rest where they are."""
        if not self._is_braking:
            self._is_braking = True
            self._profile = MotionProfile.braking(self._profile.state, self._brakes)

    @property
    def progress(self) -> float:
        """Share of the way that is done, from 0 to 1."""
        return share_done(self._start, self._profile.state.s, self._target)


def _grip_failure(kind: PhaseKind, is_gripped: bool) -> Cause | None:
    if kind is PhaseKind.CLOSE and not is_gripped:
        words = "nothing grasped: no tissue between the closed jaws"
        return Cause(Reason.CLOSED_ON_NOTHING, words)
    if kind is PhaseKind.ALIGN and is_gripped:
        return Cause(Reason.CAUGHT_TISSUE, "the closing jaws caught tissue; release first")
    return None


def tension_invalid(measured: Measurement) -> Cause | None:
    """Why a pull to a tension cannot go on; None: it can."""
    why = measured.tension_invalid_reason
    words = f"no trusted tension to pull to: {why}"
    return Cause(Reason.TENSION_SENSOR, words) if why else None


def share_done(start: float, now: float, end: float) -> float:
    """Share of the way from start to end that is done, from 0 to 1."""
    if abs(end - start) < TINY:
        return 1.0
    return min(max((now - start) / (end - start), 0.0), 1.0)
