# SPDX-License-Identifier: BSD-3-Clause
"""Item 1: planned RCM error of random paths, by two other forward kinematics than the planner's."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pybullet
import PyKDL
from numpy.typing import NDArray

from bench.common.rig import random_poses
from rst_control.config import URDF_FILE, MotionConfig
from rst_control.errors import Infeasible
from rst_control.kinematics.configuration import robot_joints
from rst_control.kinematics.rcm import rcm_error_vector
from rst_control.kinematics.robot_model import load_robot as load_model
from rst_control.planning.planner import Planner
from rst_control.simulation.physics import joint_indices, link_indices, load_robot
from rst_control.trajectory.motion_profile import MotionProfile
from rst_control.trajectory.path import Path
from rst_control.types import PathState
from support.figures import Figure
from support.kdl_chain import kdl_chain

Array = NDArray[np.float64]
Ends = tuple[Array, Array]  # of the shaft, base frame [m]

RATE = 10_000.0  # [Hz] of the samples along each path at the speed it is planned for
BLOCK = 50  # samples of each path, in places drawn at random, that PyBullet and KDL are asked about


def measure(config: MotionConfig, count: int) -> list[Figure]:
    """Plan random paths and look at the shaft everywhere on them.

    All 10 kHz samples are taken by the compiled kinematics, since the oracles are a hundred times
    slower; the oracles look at the worst sample and at a random part of every path.

    Args:
        config: Settings of planning.
        count: Number of paths.
    """
    planner = Planner(load_model(), config)
    client = pybullet.connect(pybullet.DIRECT)
    oracles = {"PyBullet": _bullet_shaft(client), "KDL": _kdl_shaft(planner)}
    worst, samples = dict.fromkeys(("compiled", *oracles), 0.0), 0
    differences, rng = dict.fromkeys(oracles, 0.0), np.random.default_rng(1)
    try:
        for path in random_paths(planner, count):
            joints, own = _sampled(planner, path)
            samples += len(own)
            worst["compiled"] = max(worst["compiled"], float(own.max()))
            chosen = np.append(rng.integers(0, len(own), BLOCK), own.argmax())
            for name, shaft in oracles.items():
                for k in chosen:
                    error = _error(shaft(joints[k]), planner.trocar)
                    worst[name] = max(worst[name], error)
                    differences[name] = max(differences[name], abs(error - own[k]))
    finally:
        pybullet.disconnect(client)
    return _figures(worst, differences, samples, count)


def random_paths(planner: Planner, count: int) -> Iterator[Path]:
    """Paths between random poses in the workspace, each from where the last one ended."""
    q, made = np.array(planner.config.scene.home), 0
    for pose in random_poses(planner.config, 20 * count, seed=1):
        try:
            path = planner.leg(q, pose)
        except Infeasible:
            continue
        q, made = path.end, made + 1
        yield path
        if made == count:
            return
    raise RuntimeError(f"only {made} of {count} random paths could be planned")


def _sampled(planner: Planner, path: Path) -> tuple[Array, Array]:
    """Joints (n, 9) [rad] and RCM errors (n,) [m] at 10 kHz of the motion along a path."""
    bounds = planner.bounds(path, planner.config.controller.speed.tip_speed)
    profile = MotionProfile(PathState(0.0), bounds)
    profile.go_to(path.length)
    per_knot = int(np.ceil(profile.remaining * RATE / (len(path.knots) - 1)))
    samples = path.sample(planner.model.chain, planner.trocar, per_knot)
    return samples.q[:, 0], samples.rcm_error


def _error(ends: Ends, trocar: Array) -> float:
    shaft = ends[1] - ends[0]
    return float(np.linalg.norm(rcm_error_vector(ends[0], shaft / np.linalg.norm(shaft), trocar)))


def _bullet_shaft(client: int) -> Callable[[Array], Ends]:
    robot = load_robot(URDF_FILE, client)
    joints, links = joint_indices(robot, client), link_indices(robot, client)
    ends = [links["interface_link"], links["pitch_link"]]

    def shaft(q: Array) -> Ends:
        for joint, angle in zip(joints, robot_joints(q, 0.0), strict=True):
            pybullet.resetJointState(robot, joint, float(angle), physicsClientId=client)
        states = pybullet.getLinkStates(
            robot, ends, computeForwardKinematics=1, physicsClientId=client
        )
        return np.array(states[0][4]), np.array(states[1][4])

    return shaft


def _kdl_shaft(planner: Planner) -> Callable[[Array], Ends]:
    chains = [kdl_chain(planner.model, name) for name in ("interface_link", "pitch_link")]
    solvers = [PyKDL.ChainFkSolverPos_recursive(chain) for chain in chains]

    def end(number: int, q: Array) -> Array:
        # Solvers only refer to their chain: naming it here keeps it alive.
        array, frame = PyKDL.JntArray(chains[number].getNrOfJoints()), PyKDL.Frame()
        for j in range(array.rows()):
            array[j] = float(q[j])
        solvers[number].JntToCart(array, frame)
        return np.array([frame.p.x(), frame.p.y(), frame.p.z()])

    def shaft(q: Array) -> Ends:
        return end(0, q), end(1, q)

    return shaft


def _figures(
    worst: dict[str, float], differences: dict[str, float], samples: int, count: int
) -> list[Figure]:
    note = f"({count} random paths, {samples} samples, evenly along s, as many as 10 kHz gives)"
    figures = [
        Figure("planned RCM error max, all samples", worst["compiled"] * 1e6, "um", 1.0, note=note)
    ]
    looked = f"({BLOCK + 1} samples of each path: its worst and {BLOCK} at random)"
    for name, difference in differences.items():
        floor = "(PyBullet gives poses in single precision)" if name == "PyBullet" else ""
        figures += [
            Figure(f"planned RCM error max by {name}", worst[name] * 1e6, "um", 1.0, note=looked),
            Figure(f"{name} away from ours, max", difference * 1e6, "um", note=floor),
        ]
    return figures
