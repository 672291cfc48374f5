# SPDX-License-Identifier: BSD-3-Clause
"""Item 8: random sheets of tissue, grasped, pulled and judged by `rst_control.triangulation`.

The controller's own verification plans the reach and the pull, its tension control pulls, and the
simulator's tissue answers; between set-points the joints are taken as exact. What the controller
believes of each sheet is a little wrong, as after a measurement.
"""

from __future__ import annotations

from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from bench.figures import Figure
from bench.motion.rig import turned
from rst_control import chain
from rst_control.backends.tissue import Tissue, rest_points, rim_nodes
from rst_control.config import MotionConfig, TissueConfig
from rst_control.configuration import Configuration, robot_joints
from rst_control.path import Path
from rst_control.planner import Planner
from rst_control.profile import Bounds
from rst_control.robot_model import load_robot
from rst_control.tension import TensionControl
from rst_control.triangulation import TriangulationLimits, pull_direction, triangulation
from rst_control.types import (
    Accepted,
    Measurement,
    PathState,
    Phase,
    Request,
    Situation,
)
from rst_control.verification import Verifier

Array = NDArray[np.float64]

LIMITS = TriangulationLimits(0.001, np.radians(30.0), 0.001, (0.3, 1.0), 0.6)
TENSION = 0.35  # [N] asked for
MOST_PULL = 0.35  # share of the sheet's height that it is pulled, at most
PLACE_ERROR = 0.0002  # [m] standard deviation of the sheet's place as the controller knows it
TURN_ERROR = np.radians(2.0)  # [rad] the same of its orientation, about each axis
TURNS = (
    0.0,
    0.4,
    -0.4,
    0.7,
    -0.7,
    1.0,
    -1.0,
)  # [rad] of the jaws about their approach, tried in this order
TILTS = (0.0, 0.3, -0.3, 0.6, -0.6)  # [rad] of the approach within the sheet, likewise
RIMS = (("start",), ("start", "left"), ("start", "right"), ("start", "left", "right"))
NODES = (9, 9)
STEP = 0.001  # [s] of the tissue
PROCESSES = 2
LONGEST = 10.0  # [s] of a pull


@dataclass(frozen=True, eq=False)
class Sheet:
    """A random tissue, and what is to be done with it."""

    tissue: TissueConfig
    grasp: Array  # (3,), where it should be grasped
    T_error: tuple[Array, Array]  # rotation (3, 3) and shift (3,) of what the controller believes


def measure(config: MotionConfig, count: int) -> list[Figure]:
    """Triangulate random tissues.

    Args:
        config: Settings of the controller.
        count: Number of tissues.
    """
    with ProcessPoolExecutor(PROCESSES) as pool:
        results = list(pool.map(partial(_try, config), range(count), chunksize=20))
    good = sum(not words for words in results)
    kinds = Counter(name.split(" ")[0] for words in results for name in words)
    named = ", ".join(f"{n} x {name}" for name, n in kinds.most_common())
    note = f"({good} of {count} tissues; failures: {named or 'none'})"
    return [Figure("triangulated tissues", 100.0 * good / count, "%", 99.0, False, note)]


def random_sheet(config: MotionConfig, seed: int) -> Sheet:
    """Draw a tissue whose grasp point and pull lie in the workspace."""
    rng, scene = np.random.default_rng([8, seed]), config.scene
    while True:
        sheet = _drawn(config, rng)
        pulled = sheet.grasp + _longest(sheet) * _way(sheet)
        away = np.array([sheet.grasp, pulled]) - scene.workspace_centre
        if np.linalg.norm(away, axis=1).max() < 0.97 * scene.workspace_radius:
            return sheet


def _drawn(config: MotionConfig, rng: np.random.Generator) -> Sheet:
    """Draw size, stiffness, rim, grasp point and orientation of a tissue."""
    scene = config.scene
    R = turned(rng.uniform(-0.35, 0.35, 3))
    size = (float(rng.uniform(0.04, 0.09)), float(rng.uniform(0.05, 0.10)))
    along, across = R @ scene.tissue.along, R @ scene.tissue.across
    top = scene.workspace_centre + rng.uniform(-0.015, 0.015, 3) - [0.0, 0.0, 0.012]
    sheet = replace(
        scene.tissue,
        size=size,
        nodes=NODES,
        stiffness=float(np.exp(rng.uniform(np.log(30.0), np.log(1500.0)))),
        rim=RIMS[rng.integers(len(RIMS))],
        along=tuple(along),
        across=tuple(across),
        centre=tuple(top - 0.5 * size[0] * along),
    )
    points, rim = rest_points(sheet), rim_nodes(sheet)
    free_edge = np.arange(NODES[0] * NODES[1])[-NODES[1] :][1:-1]
    grasp = points[rng.choice(free_edge)]
    way = pull_direction(points[rim], grasp)
    sheet = replace(sheet, reference_point=tuple(grasp), reference_pull=tuple(0.01 * way))
    error = turned(rng.normal(0.0, TURN_ERROR, 3)), rng.normal(0.0, PLACE_ERROR, 3)
    return Sheet(sheet, grasp, error)


def _way(sheet: Sheet) -> Array:
    """Where to pull, as the sheet truly lies. Shape (3,)."""
    points, rim = rest_points(sheet.tissue), rim_nodes(sheet.tissue)
    return pull_direction(points[rim], sheet.grasp)


def _longest(sheet: Sheet) -> float:
    """Furthest pull [m]."""
    return MOST_PULL * sheet.tissue.size[0]


def _believed(config: MotionConfig, sheet: Sheet, turn: float, tilt: float) -> MotionConfig:
    """Scene as the controller knows it, with one way to approach."""
    R, shift = sheet.T_error
    along, across = R @ sheet.tissue.along, R @ sheet.tissue.across
    approach = -turned(tilt * np.cross(along, across)) @ along
    scene = replace(
        config.scene,
        grasp_point=tuple(sheet.grasp + shift),
        approach_axis=tuple(approach),
        jaw_axis=tuple(turned(turn * approach) @ across),
        pull_direction=tuple(R @ _way(sheet)),
        max_displacement=_longest(sheet),
    )
    return replace(config, scene=scene)


def _try(config: MotionConfig, seed: int) -> tuple[str, ...]:
    """What went wrong with one tissue; empty: nothing."""
    sheet, refusal = random_sheet(config, seed), ""
    for tilt in TILTS:
        for turn in TURNS:
            believed = _believed(config, sheet, turn, tilt)
            planner = Planner(load_robot(), believed)
            decision = Verifier(planner)(Request("tense", TENSION), _at_home(believed))
            if isinstance(decision, Accepted):
                return _pull(planner, sheet, decision)
            refusal = refusal or f"refused: {decision.reason.value}"
    return (refusal,)


def _pull(planner: Planner, sheet: Sheet, decision: Accepted) -> tuple[str, ...]:
    phase, tissue = decision.plan.phases[-1], Tissue(sheet.tissue, STEP)
    path = phase.path
    if path is None:
        return ("no pull planned",)
    jaws = Configuration(planner.model, path.start).tip
    missed = sheet.grasp - jaws
    if not tissue.grasp(jaws):
        return ("grasp found no tissue",)
    force, end = _pulled(planner, phase, path, tissue)
    held = triangulation(
        tissue.nodes, tissue.rim, end + missed, missed, force, float(tissue.max_strain)
    )
    return held.failures(LIMITS)


def _pulled(planner: Planner, phase: Phase, path: Path, tissue: Tissue) -> tuple[float, Array]:
    """Pull until settled or at the furthest; returns tension [N] and place of the jaws (3,)."""
    settings = planner.config.controller
    bounds = Bounds(phase.speed, phase.acceleration, settings.speed.jerk)
    control = TensionControl(
        settings.tension, bounds, phase.target, PathState(0.0), phase.tension or 0.0
    )
    period, frames = 1.0 / settings.rate, np.empty((12, 3, 4))
    force, tip = np.zeros(3), Configuration(planner.model, path.start).tip
    for _ in range(round(LONGEST / period)):
        if control.is_settled or control.is_at_limit:
            break
        state = control.step(float(np.linalg.norm(force)), period)
        chain.forward(planner.model.chain, path.evaluate(state.s).q, frames)
        last, tip = tip, frames[chain.TIP, :, 3].copy()
        tissue.advance(0.5 * (last + tip))
        force = tissue.advance(tip)
    for _ in range(200):
        force = tissue.advance(tip)
    return float(np.linalg.norm(force)), tip


def _at_home(config: MotionConfig) -> Situation:
    joints = robot_joints(np.array(config.scene.home), 0.0)
    measurement = Measurement(joints, np.zeros(10), np.zeros(10), 10.0)
    return Situation(measurement, 10.0, joints, is_active=True)
