# SPDX-License-Identifier: BSD-3-Clause
"""Item 8: random sheets of tissue, grasped, pulled and judged by `tissue.triangulation`.

The controller's own verification chooses how to take each sheet and plans reach, pull and retreat;
its tension control pulls, and the simulator's tissue answers. Between set-points the joints are
taken as exact. What the controller believes of each sheet is a little wrong, as after a
measurement.
"""

from __future__ import annotations

import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from rst_control.commands.request import Accepted, Request, Situation
from rst_control.commands.table import COMMANDS
from rst_control.commands.verifier import Verifier
from rst_control.config import MotionConfig, TissueConfig
from rst_control.kinematics import forward
from rst_control.kinematics.configuration import Configuration, robot_joints
from rst_control.kinematics.robot_model import load_robot
from rst_control.kinematics.rotations import turned
from rst_control.planning.plan import Phase
from rst_control.planning.planner import Planner
from rst_control.simulation.tissue import SimulatedTissue
from rst_control.tension.control import TensionControl
from rst_control.tissue.sheet import rest_points, rim_nodes
from rst_control.tissue.triangulation import pull_direction, triangulation
from rst_control.trajectory.motion_profile import MotionBounds
from rst_control.trajectory.path import Path
from rst_control.types import ControllerMode, Measurement, PathState, State
from support.figures import Figure, share

Array = NDArray[np.float64]

TENSION = 0.35  # [N] asked for
PLACE_ERROR = 0.0002  # [m] standard deviation of the sheet's place as the controller knows it
TURN_ERROR = np.radians(2.0)  # [rad] the same of its orientation, about each axis
PULLED = 0.35  # share of the sheet's height that may be needed of the workspace beyond the grasp
RIMS = (("start",), ("start", "left"), ("start", "right"), ("start", "left", "right"))
NODES = (9, 9)
STEP = 0.001  # [s] of the tissue
PROCESSES = 2
LONGEST = 10.0  # [s] of a pull


@dataclass(frozen=True)
class Attempt:
    """How one tissue went."""

    faults: tuple[str, ...]  # empty: none
    time: float  # [s] of the processor for the verification, with the choice of the grasp


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
    with ProcessPoolExecutor(PROCESSES, initializer=_warm_up, initargs=(config,)) as pool:
        attempts = list(pool.map(partial(attempt, config), range(count), chunksize=20))
    good = sum(not a.faults for a in attempts)
    kinds = Counter(fault.split(" ")[0] for a in attempts for fault in a.faults)
    named = ", ".join(f"{n} x {name}" for name, n in kinds.most_common())
    note = f"tissues; failures: {named or 'none'}"
    times = [1e3 * a.time for a in attempts]
    return [
        share("triangulated tissues", good, count, 99.0, note=note),
        Figure("grasp choice, verified: processor time median", float(np.median(times)), "ms"),
        Figure(
            "grasp choice, verified: processor time p99",
            float(np.percentile(times, 99)),
            "ms",
            20.0,
            note=f"(max {max(times):.1f} ms)",
        ),
    ]


def _warm_up(config: MotionConfig) -> None:
    """Have everything compiled, as the controller has at its start."""
    Verifier(Planner(load_robot(), config)).warm_up()


def random_sheet(config: MotionConfig, seed: int) -> Sheet:
    """Draw a tissue whose grasp point and pull lie in the workspace."""
    rng, scene = np.random.default_rng([8, seed]), config.scene
    while True:
        sheet = _drawn(config, rng)
        pulled = sheet.grasp + PULLED * sheet.tissue.size[0] * _way(sheet)
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


def believed(config: MotionConfig, sheet: Sheet) -> MotionConfig:
    """Settings with the sheet as the controller knows it; how to take it is left to it."""
    R, shift = sheet.T_error
    tissue = replace(
        sheet.tissue,
        along=tuple(R @ sheet.tissue.along),
        across=tuple(R @ sheet.tissue.across),
        centre=tuple(sheet.grasp + shift + R @ (sheet.tissue.centre - sheet.grasp)),
    )
    scene = replace(
        config.scene,
        tissue=tissue,
        grasp_point=tuple(sheet.grasp + shift),
        approach_axis=(),
        jaw_axis=(),
        pull_direction=(),
    )
    return replace(config, scene=scene)


def attempt(config: MotionConfig, seed: int) -> Attempt:
    """Triangulate one random tissue."""
    sheet = random_sheet(config, seed)
    settings = believed(config, sheet)
    planner = Planner(load_robot(), settings)
    verify, situation = Verifier(planner), _at_home(settings)
    begin = time.thread_time()
    decision = verify(Request(COMMANDS["tense"], TENSION), situation)
    took = time.thread_time() - begin
    if not isinstance(decision, Accepted):
        return Attempt((f"refused: {decision.reason.value}",), took)
    return Attempt(_pull(planner, sheet, decision), took)


def _pull(planner: Planner, sheet: Sheet, decision: Accepted) -> tuple[str, ...]:
    phase, tissue = decision.plan.phases[-1], SimulatedTissue(sheet.tissue, STEP)
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
    return held.failures(planner.config.scene.triangulation)


def _pulled(
    planner: Planner, phase: Phase, path: Path, tissue: SimulatedTissue
) -> tuple[float, Array]:
    """Pull until settled or at the furthest; returns tension [N] and place of the jaws (3,)."""
    settings = planner.config.controller
    bounds = MotionBounds(phase.speed, phase.acceleration, settings.speed.jerk)
    brakes = MotionBounds(phase.speed, phase.braking, settings.speed.braking_jerk)
    control = TensionControl(
        settings.tension, bounds, brakes, phase.target, PathState(0.0), phase.tension or 0.0
    )
    period, frames = 1.0 / settings.rate, np.empty((12, 3, 4))
    force, tip = np.zeros(3), Configuration(planner.model, path.start).tip
    for _ in range(round(LONGEST / period)):
        if control.is_settled or control.is_at_limit:
            break
        state = control.step(float(np.linalg.norm(force)), period)
        forward.forward(planner.model.chain, path.evaluate(state.s).q, frames)
        last, tip = tip, frames[forward.TIP, :, 3].copy()
        tissue.advance(0.5 * (last + tip))
        force = tissue.advance(tip)
    for _ in range(200):
        force = tissue.advance(tip)
    return float(np.linalg.norm(force)), tip


def _at_home(config: MotionConfig) -> Situation:
    joints = robot_joints(np.array(config.scene.home), 0.0)
    measurement = Measurement(joints, np.zeros(10), np.zeros(10), 10.0)
    return Situation(measurement, 10.0, joints, ControllerMode(State.ACTIVE, is_active=True))
