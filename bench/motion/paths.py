# SPDX-License-Identifier: BSD-3-Clause
"""Item 1: planned RCM error of random paths, by two other forward kinematics than the planner's."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from bench.common.rig import random_poses
from bench.motion.bullet.robot import BulletRobot
from rst_control.config import MotionConfig
from rst_control.errors import Infeasible
from rst_control.kinematics.configuration import robot_joints
from rst_control.kinematics.rcm import rcm_error_vector
from rst_control.kinematics.robot_model import RobotModel, load_robot
from rst_control.planning.planner import Planner
from rst_control.trajectory.motion_profile import MotionProfile
from rst_control.trajectory.path import Path
from rst_control.types import PathState
from support.figures import Figure
from support.kdl_chain import Kdl

Array = NDArray[np.float64]
Shaft = Callable[[Array], Array]  # both its ends (2, 3) [m], base frame, of joints (10,) [rad]

ENDS = ("interface_link", "pitch_link")
RATE = 10_000.0  # [Hz] of the samples along each path at the speed it is planned for
BLOCK = 50  # samples of each path, in places drawn at random, that PyBullet and KDL are asked about


def measure(config: MotionConfig, count: int) -> list[Figure]:
    """Plan random paths and measure the RCM error everywhere on them.

    All 10 kHz samples are taken by the compiled kinematics, since the oracles are a hundred times
    slower. The oracles check the worst sample and a random part of every path.

    Args:
        config: Settings of planning.
        count: Number of paths.
    """
    planner = Planner(load_robot(), config)
    oracles = {"PyBullet": by_bullet(BulletRobot()), "KDL": by_kdl(planner.model)}
    worst, samples = dict.fromkeys(("compiled", *oracles), 0.0), 0
    differences, rng = dict.fromkeys(oracles, 0.0), np.random.default_rng(1)
    for path, _ in random_paths(planner, count):
        joints, own = _sampled(planner, path)
        samples += len(own)
        worst["compiled"] = max(worst["compiled"], float(own.max()))
        chosen = np.append(rng.integers(0, len(own), BLOCK), own.argmax())
        for name, shaft in oracles.items():
            for k in chosen:
                error = shaft_error(shaft(robot_joints(joints[k], 0.0)), planner.trocar)
                worst[name] = max(worst[name], error)
                differences[name] = max(differences[name], abs(error - own[k]))
    return _figures(worst, differences, samples, count)


def random_paths(
    planner: Planner, count: int, seed: int = 1, spread: float = 0.4
) -> Iterator[tuple[Path, Array]]:
    """Paths between random poses in the workspace, each from where the last one ended.

    Args:
        planner: Plans them from its home on.
        count: Number of paths.
        seed: Of the poses.
        spread: Of their turns, as `random_poses` takes it [rad].

    Yields:
        Each path with the pose (4, 4) of the tool that it leads to.
    """
    q, made = np.array(planner.config.scene.home), 0
    for pose in random_poses(planner.config, 20 * count, seed, spread):
        try:
            path = planner.leg(q, pose)
        except Infeasible:
            continue
        q, made = path.end, made + 1
        yield path, pose
        if made == count:
            return
    raise RuntimeError(f"only {made} of {count} random paths could be planned")


def by_bullet(robot: BulletRobot) -> Shaft:
    """PyBullet's view of the shaft, which knows nothing of our model."""

    def shaft(joints: Array) -> Array:
        robot.place(joints)
        return robot.poses(ENDS)[:, :, 3]

    return shaft


def by_kdl(model: RobotModel) -> Shaft:
    """KDL's view of the shaft."""
    chains = [Kdl(model, name) for name in ENDS]

    def shaft(joints: Array) -> Array:
        turning = np.delete(joints[:8], list(model.locked))  # of the arm, and pitch
        return np.array([chain.frame(turning)[:3, 3] for chain in chains])

    return shaft


def shaft_error(ends: Array, trocar: Array) -> float:
    """Distance [m] of the line through both ends (2, 3) of the shaft from the trocar (3,)."""
    shaft = ends[1] - ends[0]
    return float(np.linalg.norm(rcm_error_vector(ends[0], shaft / np.linalg.norm(shaft), trocar)))


def _sampled(planner: Planner, path: Path) -> tuple[Array, Array]:
    """Joints (n, 9) [rad] and RCM errors (n,) [m] at 10 kHz of the motion along a path."""
    bounds = planner.pace(path, planner.config.controller.speed.tip_speed).moving
    profile = MotionProfile(PathState(0.0), bounds)
    profile.go_to(path.length)
    per_knot = int(np.ceil(profile.remaining * RATE / (len(path.knots) - 1)))
    samples = path.sample(planner.model.chain, planner.trocar, per_knot)
    return samples.q[:, 0], samples.rcm_error


def _figures(
    worst: dict[str, float], differences: dict[str, float], samples: int, count: int
) -> list[Figure]:
    note = f"({count} random paths, {samples} samples, evenly along s, as many as 10 kHz gives)"
    figures = [
        Figure("planned RCM error max, all samples", worst["compiled"] * 1e6, "um", 1.0, note=note)
    ]
    note = f"({BLOCK + 1} samples of each path: its worst and {BLOCK} at random)"
    for name, difference in differences.items():
        floor = "(PyBullet gives poses in single precision)" if name == "PyBullet" else ""
        figures += [
            Figure(f"planned RCM error max by {name}", worst[name] * 1e6, "um", 1.0, note=note),
            Figure(f"{name} away from ours, max", difference * 1e6, "um", note=floor),
        ]
    return figures
