# SPDX-License-Identifier: BSD-3-Clause
"""Item 3: inverse kinematics of the full tool pose with the shaft through the trocar."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from rst_control.config import MotionConfig
from rst_control.errors import TrocarDrift
from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.rcm import rcm_state
from rst_control.kinematics.robot_model import load_robot
from rst_control.planning.planner import Planner
from support.figures import Figure, share

Array = NDArray[np.float64]

SOLVED = 1e-6  # [m] of pose and trocar that may be missing (a radian counts as 0.1 m)
STRIDE = 0.5  # [rad] of each joint, most, from one random target to the next
FRESH = 50  # targets after which the wandering begins at home again


def measure(config: MotionConfig, count: int) -> list[Figure]:
    """Solve random reachable poses from home.

    Args:
        config: Settings of planning.
        count: Number of random poses.
    """
    planner = Planner(load_robot(), config)
    planner.warm_up()
    poses = reachable(planner, count)
    home = np.array(config.scene.home)
    missing, times = np.empty(count), np.empty(count)
    for n, pose in enumerate(poses):
        begin = time.perf_counter()
        result = planner.solver.search(pose, planner.trocar, home)
        times[n] = time.perf_counter() - begin
        missing[n] = _missing(planner, result.q, pose)
    solved, quick = missing <= SOLVED, (missing <= SOLVED) & (times <= 0.010)
    note = "reachable poses, from home, without a seed"
    p50, p99 = np.percentile(times, (50, 99))
    return [
        share("IK solved to 1 um inside limits", int(solved.sum()), count, 99.99, note=note),
        share("IK solved within 10 ms", int(quick.sum()), count, 99.95),
        Figure("IK time median", p50 * 1e6, "us", 200.0),
        Figure("IK time p99", p99 * 1e6, "us"),
        Figure("IK time max", times.max() * 1e3, "ms"),
    ]


def reachable(planner: Planner, count: int) -> list[Array]:
    """Poses (4, 4) of tool_tip that some joints within all limits reach through the trocar.

    Joints wander at random from home on; each time they are put onto the trocar by the smallest
    change, and kept where limits, insertion and workspace hold.
    """
    rng, poses = np.random.default_rng(3), list[Array]()
    home, (low, high) = np.array(planner.config.scene.home), planner.config.rcm.insertion
    radius = planner.config.scene.workspace_radius
    last = home
    while len(poses) < count:
        try:
            q = planner.project(last + rng.uniform(-STRIDE, STRIDE, 9))
        except TrocarDrift:
            continue
        here = Configuration(planner.model, q)
        if planner.limits.violation(q) is not None:
            continue
        if not low <= rcm_state(here, planner.trocar).insertion <= high:
            continue
        if np.linalg.norm(here.tip - planner.centre) <= radius:
            poses.append(here.T_base_tip)
            last = q if len(poses) % FRESH else home
    return poses


def _missing(planner: Planner, q: Array, pose: Array) -> float:
    """What is missing to pose and trocar [m]; infinite outside joint limits."""
    if planner.limits.violation(q) is not None:
        return float("inf")
    here = Configuration(planner.model, q)
    tip = here.T_base_tip
    cosine = 0.5 * (np.trace(tip[:3, :3].T @ pose[:3, :3]) - 1.0)
    sine = 0.5 * np.linalg.norm(tip[:3, :3] - pose[:3, :3]) / np.sqrt(2.0)
    turn = 2.0 * np.arctan2(sine, np.sqrt(max(0.0, 0.5 * (1.0 + cosine))))
    shift = float(np.linalg.norm(tip[:3, 3] - pose[:3, 3]))
    return max(shift, 0.1 * float(turn), rcm_state(here, planner.trocar).error)
