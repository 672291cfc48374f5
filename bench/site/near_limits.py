# SPDX-License-Identifier: BSD-3-Clause
"""Inverse kinematics where one to three joints are within 5 mrad of their limits."""

from __future__ import annotations

import os
import time
from typing import Any, Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from bench.common.resumable import measured
from rst_control.config import load_motion_config
from rst_control.kinematics import constrained_ik
from rst_control.kinematics import forward as kin
from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.ik_solver import IkResult
from rst_control.kinematics.rcm import rcm_jacobian, rcm_offset, rcm_state
from rst_control.kinematics.robot_model import load_robot
from rst_control.planning.planner import Planner
from support.figures import Figure, share

Array = NDArray[np.float64]
FULL: Final = 3000  # poses
POSES: Final = int(os.environ.get("BENCH_NEAR_LIMITS", str(FULL)))
NEAR: Final = 0.005  # [rad] of a joint from its limit, at most
SOLVED: Final = 1e-9  # [m] of pose and trocar that may be missing (a radian counts as 0.1 m)
QUICK: Final = 0.010  # [s]
STRIDE: Final = 1.5  # [rad] of each other joint from home, at most
PROJECTIONS: Final = 30
IN_TROCAR: Final = 1e-11  # [m]


def measure() -> list[Figure]:
    """Solve reachable poses from home, with no hint."""
    planner = Planner(load_robot(), load_motion_config())
    planner.warm_up()
    home = np.array(planner.config.scene.home)
    solved, times = [], []
    for _, pose in near_limits(planner, POSES, seed=17):
        begin = time.perf_counter()
        result = planner.solver.search(pose, planner.trocar, home)
        times.append(time.perf_counter() - begin)
        solved.append(is_right(planner, result, pose))
    quick = int(np.sum(np.array(solved) & (np.array(times) <= QUICK)))
    note = "reachable poses; 1 to 3 joints within 5 mrad of a limit"
    return [
        measured(POSES, "poses", FULL),
        share("IK near joint limits: solved", sum(solved), POSES, 99.9, note=note),
        share("IK near joint limits: solved within 10 ms", quick, POSES, 99.9),
        Figure("IK near joint limits: time p99", float(np.percentile(times, 99)) * 1e3, "ms"),
    ]


def is_right(planner: Planner, result: IkResult, pose: Array) -> bool:
    """The joints found are within all limits and take the tool there through the trocar."""
    r = np.empty(8)
    frames = Configuration(planner.model, result.q).frames
    missing = constrained_ik.residual(frames, pose[:3], planner.trocar, r)
    return result.is_solved and planner.limits.violation(result.q) is None and missing <= SOLVED


def near_limits(planner: Planner, count: int, seed: int) -> list[tuple[Array, Array]]:
    """Joints (9,) with one to three near a limit, and their poses (4, 4) of tool_tip."""
    rng, found = np.random.default_rng(seed), list[tuple[Array, Array]]()
    home, (least, most) = np.array(planner.config.scene.home), planner.config.rcm.insertion
    limits, chain = planner.limits, planner.model.chain
    while len(found) < count:
        held = np.zeros(9, dtype=np.bool_)
        held[rng.choice(9, int(rng.integers(1, 4)), replace=False)] = True
        room, is_upper = rng.uniform(0.0, NEAR, 9), rng.random(9) < 0.5
        q = home + rng.uniform(-STRIDE, STRIDE, 9)
        q[held] = np.where(is_upper, limits.upper - room, limits.lower + room)[held]
        if not _put_into_trocar(chain, planner.trocar, q, held) or limits.violation(q) is not None:
            continue
        here = Configuration(planner.model, q)
        is_inside = least <= rcm_state(here, planner.trocar).insertion <= most
        radius = planner.config.scene.workspace_radius
        if is_inside and np.linalg.norm(here.tip - planner.centre) <= radius:
            found.append((q, here.T_base_tip))
    return found


@njit(nogil=True)  # type: ignore[untyped-decorator]
def _put_into_trocar(chain: Any, trocar: Any, q: Any, held: Any) -> bool:
    """Move the joints q (9,), in place, until the shaft is in the trocar; not those `held` (9,)."""
    frames, J = np.empty((12, 3, 4)), np.zeros((2, 9))
    for _ in range(PROJECTIONS):
        kin.forward(chain, q, frames)
        x, y, _ = rcm_offset(frames, trocar)
        if max(abs(x), abs(y)) < IN_TROCAR:
            return True
        rcm_jacobian(frames, trocar, J)
        a, b, d = 0.0, 0.0, 0.0
        for j in range(9):
            if held[j]:
                J[0, j], J[1, j] = 0.0, 0.0
            a, b, d = a + J[0, j] ** 2, b + J[0, j] * J[1, j], d + J[1, j] ** 2
        square = a * d - b * b
        if square < 1e-12:
            return False
        u, v = (d * x - b * y) / square, (a * y - b * x) / square
        for j in range(9):
            q[j] -= J[0, j] * u + J[1, j] * v
    return False
