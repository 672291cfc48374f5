# SPDX-License-Identifier: BSD-3-Clause
"""Plans straight tool motions through the trocar; each path is checked before anything moves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rst_control.config import MotionConfig
from rst_control.errors import (
    Infeasible,
    RobotModelError,
    TrocarDrift,
    Unreachable,
)
from rst_control.kinematics import continuation, forward
from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.ik_solver import IkSolver
from rst_control.kinematics.joint_limits import make_limits, require_lacking_at_zero, require_ranges
from rst_control.kinematics.rcm import rcm_jacobian, rcm_offset, rcm_state
from rst_control.kinematics.robot_model import RobotModel
from rst_control.planning.collision import CollisionModel
from rst_control.planning.path_checks import PathChecks
from rst_control.planning.patient_surface import Patient
from rst_control.planning.plan import Phase, PhaseKind
from rst_control.tissue.grasp_candidates import GraspCandidate, grasp_candidates
from rst_control.trajectory.motion_profile import MotionBounds, stopping_speed
from rst_control.trajectory.path import Path, speed_bounds
from rst_control.types import Vector, frozen_array, unit_vector

Array = NDArray[np.float64]

MIN_KNOTS: Final = 4
DENSER: Final = 4  # times as many knots where the first try strays from the trocar
SAME_PLACE: Final = 1e-7  # [m] of path below which there is nothing to move
SEAT_SCALE: Final = 1.5  # [m/rad] of path back to the trocar; the reach: no point is faster
PROJECTIONS: Final = 20
MAX_BRAKING: Final = 4.0  # [m/s^2] of s, also where the joints could brake harder


@dataclass(frozen=True)
class PathPace:
    """How a path may be taken."""

    moving: MotionBounds
    braking: MotionBounds  # as hard as the joints can


class Planner:
    """Plans straight tool motions for one robot and scene.

    It never changes, so any thread may plan.

    Args:
        model: The robot.
        config: Scene, limits and tolerances.

    Raises:
        RobotModelError: The robot lacks what the settings ask of shaft, joint ranges or links.
        ConfigError: Home turns a joint that the robot lacks.
    """

    def __init__(self, model: RobotModel, config: MotionConfig) -> None:
        _require_shaft(model, config)
        require_ranges(config.limits, model)
        require_lacking_at_zero("scene.home", config.scene.home, model)
        self.model, self.config = model, config
        self.trocar = frozen_array(config.scene.trocar, 3)
        self.centre = frozen_array(config.scene.workspace_centre, 3)
        self.limits = make_limits(config.limits, config.controller.jaws.open)
        self.solver = IkSolver(model, self.limits, config.scene.home, config.rcm.solver)
        collisions = CollisionModel(config.collision, model)
        self.checks = PathChecks(model, config, self.limits, collisions, self.trocar)
        self.patient = Patient(model, config)
        self.grasp_candidates = grasp_candidates(config.scene)

    def warm_up(self) -> None:
        """Compile or load every kernel, by planning once from home."""
        home = np.array(self.config.scene.home)
        for candidate in self.grasp_candidates:
            try:
                *_, path = self.reach(home, candidate)
                self.pull(path.end)
                break
            except Infeasible:
                if candidate is self.grasp_candidates[-1]:
                    raise
        self.pace(path, self.config.controller.speed.tip_speed)
        path.evaluate(0.0)
        self.project(home)

    def reach(self, q: Vector, candidate: GraspCandidate | None = None) -> tuple[Path, ...]:
        """Ways from q (9,) to before the grasp point, then to it; what is already done is left out.

        Args:
            q: Where to start [rad]. Shape (9,).
            candidate: How to take the sheet; None: the first that the scene leaves open.

        Raises:
            Infeasible: No such way keeps all limits; the error says which.
        """
        grasps = self._grasps(candidate or self.grasp_candidates[0])
        first, other = sorted(grasps, key=lambda grasp: self._distance(q, grasp))
        try:
            return self.route(q, self._before(first), first)
        except Infeasible as why_not:
            try:
                return self.route(q, self._before(other), other)
            except Infeasible:
                raise why_not from None

    def pull(self, q: Vector) -> Path:
        """Way from the grasp at q (9,) along the pull direction, as far as pulling may ever go.

        Raises:
            Infeasible: No such way keeps all limits; the error says which.
        """
        candidate = self.grasp_candidates[0]  # all pull alike
        goal = Configuration(self.model, q).T_base_tip
        goal[:3, 3] += candidate.pull * candidate.length
        return self.leg(q, goal)

    def retreat(self, q: Vector) -> Path:
        """Way from q (9,) straight back out of the tissue: against where the jaws point.

        Raises:
            Infeasible: No such way keeps all limits; the error says which.
        """
        goal = Configuration(self.model, q).T_base_tip
        goal[:3, 3] += goal[:3, 1] * self.config.scene.clearance
        return self.leg(q, goal)

    def route(self, q: Vector, *goals: Array) -> tuple[Path, ...]:
        """Straight ways from q (9,) to each pose (4, 4) in turn; first to the trocar if off it.

        Raises:
            Infeasible: No such way keeps all limits; the error says which.
        """
        paths: list[Path] = []
        if rcm_state(Configuration(self.model, q), self.trocar).error > self.seated:
            paths.append(self.seat(q))
            q = paths[-1].end
        for goal in goals:
            if self._distance(q, goal) > SAME_PLACE:
                paths.append(self.leg(q, goal))
                q = paths[-1].end
        return tuple(paths)

    def seat(self, q: Vector, goal: Vector | None = None) -> Path:
        """Smallest joint motion that puts a shaft slightly off the trocar back into it.

        Args:
            q: Where it starts [rad]. Shape (9,).
            goal: Joints near by with the shaft in the trocar [rad], shape (9,); None: the nearest.

        Raises:
            TrocarDrift: The shaft is further off than may be put right by itself.
            Infeasible: The motion breaks another limit; the error says which.
        """
        allowed = self.config.rcm.measured_tolerance
        error = rcm_state(Configuration(self.model, q), self.trocar).error
        if error > allowed:
            raise TrocarDrift(error, allowed)
        seated = self.project(q) if goal is None else goal
        length = max(float(np.abs(seated - q).max()) * SEAT_SCALE, 10 * SAME_PLACE)
        slope = (seated - q) / length
        path = Path(np.array([q, seated]), np.array([slope, slope]), length)
        self.checks.seating(path.sample(self.model.chain, self.trocar))
        return path

    def project(self, q: Vector) -> Vector:
        """Nearest joints (9,) [rad] with the shaft through the trocar.

        Raises:
            TrocarDrift: There are none near.
        """
        q, frames, J = np.array(q), np.empty((12, 3, 4)), np.zeros((2, 9))
        for _ in range(PROJECTIONS):
            forward.forward(self.model.chain, q, frames)
            lateral = np.array(rcm_offset(frames, self.trocar)[:2])
            if np.abs(lateral).max() < self.config.rcm.solver.tolerance:
                return q
            rcm_jacobian(frames, self.trocar, J)
            q -= J.T @ np.linalg.solve(J @ J.T, lateral)
        raise TrocarDrift(float(np.hypot(*lateral)), self.config.rcm.solver.tolerance)

    def leg(self, q: Vector, goal: Array) -> Path:
        """Checked straight way of the tool from q (9,) to a pose (4, 4) of tool_tip in base_link.

        Raises:
            Infeasible: It breaks a limit; the error says which.
        """
        self.checks.workspace(goal[:3, 3])
        settled = self.solver.settle(q, goal, self.trocar)
        if settled.is_solved:
            try:
                return self._smooth(q, goal, settled.q)
            except Infeasible:
                pass  # the swing to the best posture leads over a limit; go without it
        return self._smooth(q, goal, q)

    def pace(self, path: Path, speed: float) -> PathPace:
        """How joints can follow a path, up to `speed` [m/s] by its scale, and stop soon enough."""
        settings, layer = self.config.controller.speed, self.config.limits.active
        speed *= settings.scale
        samples = path.sample(self.model.chain, self.trocar)
        for _ in range(2):  # slower, the path's own curvature leaves more for braking
            speed, hardest = speed_bounds(samples, self.limits, speed, MAX_BRAKING)
            braking = MotionBounds(speed, hardest, settings.braking_jerk)
            speed = stopping_speed(braking, layer.stopping_time, layer.stopping_distance)
        moving = MotionBounds(speed, min(hardest, settings.acceleration), settings.jerk)
        return PathPace(moving, braking)

    def _grasps(self, candidate: GraspCandidate) -> tuple[Array, Array]:
        """The grasp and the same with the jaws changed about, which take the tissue alike."""
        turned = candidate.T_base_tip.copy()
        turned[:3, [0, 2]] *= -1.0
        return candidate.T_base_tip, turned

    def _before(self, grasp: Array) -> Array:
        before = grasp.copy()
        before[:3, 3] += before[:3, 1] * self.config.scene.clearance
        return before

    @property
    def seated(self) -> float:
        """Distance of a seated shaft from the trocar, at most [m]."""
        return 0.1 * self.config.rcm.planned_tolerance

    def _distance(self, q: Vector, goal: Array) -> float:
        tip, turn = Configuration(self.model, q).T_base_tip, np.empty(3)
        forward.turn_between(tip, goal, turn)
        shift = float(np.linalg.norm(goal[:3, 3] - tip[:3, 3]))
        return max(shift, float(np.linalg.norm(turn)) * self.config.rcm.rotation_radius)

    def _smooth(self, q: Vector, goal: Array, posture: Vector) -> Path:
        """Knots as dense as usual, and denser where the shaft strays between them."""
        try:
            return self._checked(self._continued(q, goal, posture, self.config.rcm.knot_spacing))
        except TrocarDrift:
            spacing = self.config.rcm.knot_spacing / DENSER
            return self._checked(self._continued(q, goal, posture, spacing))

    def _continued(self, q: Vector, goal: Array, posture: Vector, spacing: float) -> Path:
        start, turn = Configuration(self.model, q).T_base_tip, np.empty(3)
        forward.turn_between(start, goal, turn)
        motion = np.array([goal[:3, 3] - start[:3, 3], turn])
        axis, length = self._swing_axis(q, posture), max(self._distance(q, goal), SAME_PLACE)
        return self.follow(q, motion, length, spacing, axis, float(axis @ (posture - q)))

    def follow(
        self,
        q: Vector,
        motion: Array,
        length: float,
        spacing: float,
        axis: Vector,
        swing: float,
        is_straight: bool = False,
    ) -> Path:
        """Path of a straight motion of the tool, not yet checked.

        Args:
            q: Where it starts [rad]. Shape (9,).
            motion: Shift [m], then turn [rad] of the tip, base frame. Shape (2, 3).
            length: Of the path [m].
            spacing: Of its knots [m], at most.
            axis: Joint direction in which the elbow swings, of length 1. Shape (9,).
            swing: How far the joints go along that direction [rad].
            is_straight: A straight tool moves along its shaft, also where the wrist is in the
                trocar.

        Raises:
            Unreachable: The arm cannot follow.
            NearSingular: The same, near a singularity. A straight tool is not judged by that.
        """
        count = max(MIN_KNOTS, int(np.ceil(length / spacing)) + 1)
        knots, slopes = np.zeros((count, 9)), np.zeros((count, 9))
        knots[0] = q
        tolerance = self.config.rcm.solver.tolerance
        missing, reached = continuation.fill_knots(
            self.model.chain,
            np.ascontiguousarray(Configuration(self.model, q).T_base_tip[:3]),
            motion,
            self.trocar,
            is_straight,
            axis,
            swing,
            length,
            tolerance,
            knots,
            slopes,
        )
        if not missing <= tolerance:
            if not is_straight:
                self.checks.manipulability(knots[: max(reached, 1)])  # may be the reason
            raise Unreachable(reached / (count - 1) * length, length)
        return Path(knots, slopes, length)

    def _swing_axis(self, q: Vector, posture: Vector) -> Vector:
        """Joint direction (9,) between those that move neither tool nor shaft at either end."""
        first, last = np.empty(9), np.empty(9)
        continuation.free_direction(self.model.chain, np.array(q), self.trocar, False, first)
        continuation.free_direction(self.model.chain, np.array(posture), self.trocar, False, last)
        return unit_vector(first + last * np.sign(first @ last))

    def _checked(self, path: Path) -> Path:
        self.checks.all(path.sample(self.model.chain, self.trocar))
        return path


def _require_shaft(model: RobotModel, config: MotionConfig) -> None:
    most, allowed = config.rcm.insertion[1], model.shaft_length
    if most > allowed:
        raise RobotModelError(f"rcm.insertion up to {most:g} m, allowed: the shaft, {allowed:g} m")


def along(planner: Planner, kind: PhaseKind, path: Path, speed: float) -> Phase:
    """Phase from one end of a path to the other, at up to `speed` [m/s]."""
    pace = planner.pace(path, speed)
    return Phase(
        kind,
        path,
        target=path.length,
        speed=pace.moving.speed,
        acceleration=pace.moving.acceleration,
        braking=pace.braking.acceleration,
    )
