# SPDX-License-Identifier: BSD-3-Clause
"""Ways into the patient and out: straight along the shaft, which never leaves the trocar.

The way in is the way out of the working pose, backwards. The wrist bends only where it is inside
the trocar by the least insertion; on this side of that the tool is straight.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rst_control.errors import (
    Infeasible,
    InsertionOutOfRange,
    LongWay,
    OutsideWorkspace,
    TrocarDrift,
    Unreachable,
)
from rst_control.kinematics import continuation
from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.joint_limits import PLAN_NAMES, TURN
from rst_control.planning.free_space import Approach
from rst_control.planning.plan import PhaseKind
from rst_control.planning.planner import DENSER, Planner
from rst_control.tissue.grasp_candidates import grasp_pose
from rst_control.trajectory.path import Path
from rst_control.types import Vector
from typed_config import require

log = logging.getLogger("rosout.rst_control.controller")
Array = NDArray[np.float64]

SWINGS: Final = tuple(0.2 * k for k in range(-6, 7))  # [rad] of the elbow, tried for the way out
STRAIGHT: Final = 1e-9  # [rad] of pitch and yaw, below which the tool counts as straight
NEARLY_STRAIGHT: Final = 0.01  # [rad] that may be straightened in the trocar: 0.3 mm at the tip
SLIGHT: Final = 1e-7  # [m] of way that is none
NO_HOME: Final = "no joints in their limits take the home pose with the shaft through the trocar"


class ToolBent(Infeasible):
    """The wrist is bent where only a straight tool may be."""

    def __init__(self, angle: float, wrist: float, least: float) -> None:
        super().__init__(
            f"tool bent by {angle:.3f} rad with its wrist {wrist * 1e3:.1f} mm inside the trocar, "
            f"allowed {NEARLY_STRAIGHT:.3f} rad below {least * 1e3:.1f} mm"
        )
        self.angle, self.wrist, self.least = angle, wrist, least


@dataclass(frozen=True, eq=False)
class Leg:
    """One path, and the phase that it belongs to."""

    kind: PhaseKind
    path: Path


class Insertion:
    """Plans insertion and withdrawal. It never changes.

    Args:
        planner: For this robot and scene.
    """

    def __init__(self, planner: Planner) -> None:
        self._planner, self._patient = planner, planner.patient
        self._scene, self._rcm = planner.config.scene, planner.config.rcm
        self._approach = Approach(
            planner.model, planner.limits, planner.patient.outside, planner.patient.outward
        )

    @cached_property
    def working(self) -> Vector:
        """Joints of the home pose, with the shaft through the trocar of this scene. Shape (9,).

        Raises:
            Infeasible: No joints within their limits take the tool there.
        """
        home, planner = np.array(self._scene.home), self._planner
        if self._patient.trocar_pose(home).error <= planner.seated:
            return home
        found = planner.solver.settle(home, self._home_pose, planner.trocar)
        if not found.is_solved:
            found = planner.solver.search(self._home_pose, planner.trocar, home)
        if not found.is_solved:
            raise Infeasible(NO_HOME)
        return found.q

    @cached_property
    def _way_in(self) -> tuple[Leg, ...]:
        """From outside the trocar to the working pose."""
        out = self._withdraw(self.working)
        return tuple(Leg(PhaseKind.INSERT, leg.path.reversed()) for leg in reversed(out))

    def _way_in_near(self, q: Vector) -> tuple[Leg, ...]:
        """The way in, each endless joint in the turn nearest to q (9,) that its limits leave."""
        legs, limits = self._way_in, self._planner.limits
        turns = limits.turns_towards(legs[0].path.start, q)
        knots = np.concatenate([leg.path.knots for leg in legs])
        turns = np.where(knots.max(axis=0) + turns > limits.upper, turns - TURN, turns)
        turns = np.where(knots.min(axis=0) + turns < limits.lower, turns + TURN, turns)
        turns = np.where(limits.endless, turns, 0.0)
        return tuple(Leg(leg.kind, leg.path.turned(turns)) for leg in legs)

    def _require_short(self, q: Vector, corners: tuple[Vector, ...]) -> None:
        """Keep an approach from q (9,) by the corners (9,) from turning a joint the long way.

        The shortest way of an endless joint counts in any turn, also where its limits rule it out.
        """
        if not corners:
            return
        direct = corners[-1] - q
        turned = np.abs(np.diff([q, *corners], axis=0)).sum(axis=0)
        shortest = np.abs(direct + self._planner.limits.turns_towards(direct, np.zeros_like(q)))
        allowed = shortest + self._rcm.max_joint_way
        worst = int((turned - allowed).argmax())
        if not turned[worst] <= allowed[worst]:
            ways = f"{turned[worst]:.2f} rad", f"{allowed[worst]:.2f} rad"
            tips = [Configuration(self._planner.model, x).tip for x in (q, corners[-1])]
            length = float(np.linalg.norm(tips[1] - tips[0]))
            raise LongWay(PLAN_NAMES[worst], ways[0], length, ways[1])

    @property
    def _home_pose(self) -> Array:
        return Configuration(self._planner.model, self._scene.home).T_base_tip

    def warm_up(self) -> None:
        """Compile or load every kernel, by planning from outside once; warns where that fails.

        Raises:
            ConfigError: The standoff leaves no margin to the surface, however the shaft stands.
        """
        self._require_standoff()
        try:
            outside = self._way_in[0].path.start
        except Infeasible as why:
            log.warning(self._no_way_out(why))
            return
        self._approach.warm_up(outside)
        self.insert(outside)

    def _require_standoff(self) -> None:
        scene, least = self._scene, self._patient.min_standoff
        margin = scene.surface_margin
        allowed = f"at least {least:.4f} m: scene.surface_margin, {margin:g} m, and what of the "
        allowed += f"jaws reaches beyond the tip, {least - margin:.4f} m"
        require(scene.standoff >= least - SLIGHT, "scene.standoff", scene.standoff, allowed)

    def _no_way_out(self, why: Infeasible) -> str:
        """What is wrong with the way between outside and the working pose, for the log."""
        scene = self._scene
        words = f'"withdraw" and "insert" will be refused at the working pose: {why}'
        words += f"; scene.standoff is {scene.standoff:g} m"
        return f"{words}, scene.surface_margin {scene.surface_margin:g} m"

    def insert(self, q: Vector) -> tuple[Leg, ...]:
        """Ways from q (9,), outside or part-way in, to the working pose.

        Raises:
            Infeasible: No such way keeps all limits; the error says which.
        """
        if not self._patient.trocar_pose(q).is_outside:
            return self._insert_on(q)
        way_in = self._way_in_near(q)
        ways = self._approach.way(np.array(q), way_in[0].path.start)
        self._require_short(q, tuple(way.end for way in ways))
        return (*(Leg(PhaseKind.APPROACH, way) for way in ways), *way_in)

    def withdraw(self, q: Vector) -> tuple[Leg, ...]:
        """Ways from q (9,), in the trocar, to outside: the tool straightened, then out along it.

        Where the arm cannot follow the present shaft that far, it goes by way of the working pose.

        Raises:
            Infeasible: No such way keeps all limits; the error says which.
        """
        try:
            return self._withdraw(q)
        except Infeasible as why_not:
            if self._patient.trocar_pose(q).wrist < self._rcm.insertion[0]:
                raise
            try:
                ways = self._planner.route(q, self._home_pose)
                legs = self._withdraw(ways[-1].end if ways else q)
            except Infeasible:
                raise why_not from None
            return (*(Leg(PhaseKind.ALIGN, way) for way in ways), *legs)

    def _withdraw(self, q: Vector) -> tuple[Leg, ...]:
        legs = self._aligned(q)
        q = legs[-1].path.end if legs else np.array(q)
        out = self._along_shaft(q, -self._patient.trocar_pose(q).insertion - self._scene.standoff)
        self._approach.require_place(out.end)
        return (*legs, Leg(PhaseKind.WITHDRAW, out))

    def _insert_on(self, q: Vector) -> tuple[Leg, ...]:
        """Further in along the shaft where it is, then inside to the working pose."""
        legs = list(self._aligned(q))
        q = legs[-1].path.end if legs else np.array(q)
        missing = self._patient.trocar_pose(self.working).wrist - self._patient.trocar_pose(q).wrist
        if missing > SLIGHT:
            legs.append(Leg(PhaseKind.INSERT, self._along_shaft(q, missing)))
            q = legs[-1].path.end
        ways = self._planner.route(q, self._home_pose)
        return (*legs, *(Leg(PhaseKind.INSERT, way) for way in ways))

    def _aligned(self, q: Vector) -> tuple[Leg, ...]:
        """The shaft put into the trocar, if slightly off it, and the tool straightened."""
        ways = list(self._planner.route(q))
        q = ways[-1].end if ways else np.array(q)
        if np.abs(q[7:]).max() > STRAIGHT:
            ways.append(self._straightened(q))
        return tuple(Leg(PhaseKind.ALIGN, way) for way in ways)

    def _straightened(self, q: Vector) -> Path:
        """By the wrist alone where there is room for the tip to swing, else about the tip."""
        bend, wrist = float(np.abs(q[7:]).max()), self._patient.trocar_pose(q).wrist
        is_inside = wrist >= self._rcm.insertion[0]
        if not is_inside and bend > NEARLY_STRAIGHT:
            raise ToolBent(bend, wrist, self._rcm.insertion[0])
        try:
            return self._checked(self._unbent(q), must_stay=is_inside)
        except Infeasible as why_not:
            try:
                return self._planner.leg(q, self._pointed(q))
            except Infeasible:
                raise why_not from None

    def _unbent(self, q: Vector) -> Path:
        straight = np.array(q)
        straight[7:] = 0.0
        length = max(float(np.abs(q[7:]).max()) * self._planner.model.wrist_length, SLIGHT)
        slope = (straight - q) / length
        return Path(np.array([q, straight]), np.array([slope, slope]), length)

    def _pointed(self, q: Vector) -> Array:
        """The tool's pose with its tip where it is, in line with the trocar."""
        pose = Configuration(self._planner.model, q).T_base_tip
        return grasp_pose(pose[:3, 3], pose[:3, 3] - self._planner.trocar, pose[:3, 2])

    def _along_shaft(self, q: Vector, way: float) -> Path:
        """Motion of a straight tool along its shaft by a way [m], inwards if positive.

        Of the elbow's swings, the one that stays furthest from the joints' limits comes first. If
        all fail, its reason is given, or that of the one that comes furthest.
        """
        candidates: list[tuple[float, float]] = []
        short: list[Unreachable] = []
        for swing in SWINGS:
            try:
                path = self._continued(q, way, swing, self._rcm.knot_spacing)
            except Unreachable as error:
                short.append(error)
                continue
            candidates.append((self._room(path), swing))
        refused: list[Infeasible] = []
        for _, swing in sorted(candidates, reverse=True):
            try:
                return self._swung(q, way, swing)
            except Infeasible as error:
                refused.append(error)
        raise refused[0] if refused else max(short, key=lambda error: error.reached)

    def _swung(self, q: Vector, way: float, swing: float) -> Path:
        """Checked, with knots as dense as usual, and denser where the shaft strays between them."""
        spacing = self._rcm.knot_spacing
        try:
            return self._checked(self._continued(q, way, swing, spacing), must_stay=False)
        except TrocarDrift:
            denser = self._continued(q, way, swing, spacing / DENSER)
            return self._checked(denser, must_stay=False)

    def _room(self, path: Path) -> float:
        limits = self._planner.limits
        return float(np.minimum(path.knots - limits.lower, limits.upper - path.knots).min())

    def _continued(self, q: Vector, way: float, swing: float, spacing: float) -> Path:
        planner, axis = self._planner, np.empty(9)
        shaft = Configuration(planner.model, q).T_base_shaft[:3, 2]
        motion = np.array([way * shaft, np.zeros(3)])
        continuation.free_direction(planner.model.chain, np.array(q), planner.trocar, True, axis)
        return planner.follow(q, motion, abs(way), spacing, axis, swing, is_straight=True)

    def _checked(self, path: Path, must_stay: bool) -> Path:
        """The path itself, once found to keep all limits.

        Args:
            path: Through the trocar.
            must_stay: The tip may not leave workspace and way to the trocar.
        """
        samples = path.sample(self._planner.model.chain, self._planner.trocar)
        self._planner.checks.rcm(samples)
        length = self._planner.model.shaft_length
        deepest, most = length - float(samples.along.min()), self._rcm.insertion[1]
        if deepest > most:
            raise InsertionOutOfRange(deepest, -self._scene.standoff, most)
        if must_stay:
            self._require_corridor(samples.tip)
        self._planner.checks.joints(samples)
        self._patient.passing.check(samples)
        return path

    def _require_corridor(self, tips: Array) -> None:
        """Keep tips (n, 3) in the workspace or on a straight way from there to the trocar.

        Those are the balls that grow from the trocar to the workspace.
        """
        centre, radius = self._planner.centre, self._scene.workspace_radius
        share = np.linspace(0.0, 1.0, 101)[:, None]
        balls = self._planner.trocar + share * (centre - self._planner.trocar)
        away = np.linalg.norm(tips[:, None] - balls, axis=2) - share[:, 0] * radius
        worst = int(away.min(axis=1).argmax())
        if away[worst].min() > 0.0:
            raise OutsideWorkspace(float(np.linalg.norm(tips[worst] - centre)), radius)
