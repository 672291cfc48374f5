# SPDX-License-Identifier: BSD-3-Clause
"""`make bench ONLY=torque_tension`: how well joint torques show the tissue's pull, in PyBullet.

PyBullet holds the arm, pulls at the jaws and leans on the shaft with forces that are known, and
says what the motors give. To that come the errors of `torque_tension.yaml`, drawn anew for each
trial; they are assumptions about a Gen3, not measurements of one. The estimator's own model knows
none of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pybullet
from numpy.typing import NDArray

from bench.common.quiet import quiet
from bench.common.rig import random_poses
from rst_control.config import URDF_FILE, MotionConfig, load_motion_config
from rst_control.config.torque_tension import TorqueTensionConfig, load_torque_tension
from rst_control.kinematics import forward
from rst_control.kinematics.configuration import Configuration, robot_joints
from rst_control.kinematics.inverse_dynamics import InverseDynamics
from rst_control.kinematics.mounting import gravity_in_base
from rst_control.kinematics.robot_model import load_robot
from rst_control.planning.planner import Planner
from rst_control.simulation.physics import RobotPhysics
from rst_control.tension.torque_covariance import TorqueErrors
from rst_control.tension.torque_estimator import (
    TorqueTension,
    least_squares,
    load_matrix,
)
from rst_control.types import Measurement, unit_vector
from support.figures import Figure, share

Array = NDArray[np.float64]
TRIALS = 120
PERIOD = 0.025  # [s] of the Gen3 driver's feedback, 40 Hz
WINDOW = 1.0  # [s] at rest before the pull, and under it
SETTLING = 40  # steps of PyBullet until the motors carry the load
STEP = 0.001  # [s]
MAX_PULL, MAX_WAY = 2.0, 0.020  # [N], [m]
LEAN = 2.0  # [N] standard deviation of the trocar on the shaft, each way across it
SEAL = 1.0  # [N] of friction in a trocar's seal, in the trials that show what it does
CASES = (  # is tared, has lean
    ("tared, shaft leans on the trocar", True, True),
    ("tared, shaft free in the trocar", True, False),
    ("not tared, shaft leans on the trocar", False, True),
)
TURN = 0.8  # [rad] of the pull away from the configured one
OPEN, CLOSED = 0.6, 0.0  # [rad] between the jaws


@dataclass(frozen=True, eq=False)
class TensionTrial:
    """A grasp, a pull, and what is wrong with the arm's torques and masses."""

    q: Array  # (2, 9), [rad] before and under the pull
    pull: Array  # (3,), unit
    force: float  # [N]
    lean: Array  # (2,), [N] of the trocar across the shaft under the pull
    offset: Array  # (7,), [N m]
    friction: Array  # (2, 7), [N m] before and under the pull
    gain: Array  # (7,), [-]
    masses: Array  # (7,), [-] share by which gravity on each joint is off
    tool_mass: float  # [kg]


class LoadedArm(RobotPhysics):
    """PyBullet's arm at rest under forces at its jaws and on its shaft."""

    def torques(self, q: Array, on_jaws: Array, on_shaft: Array, place: Array) -> Array:
        """Torques of the arm's motors once they carry the loads [N m]. Shape (7,)."""
        joints = robot_joints(q, CLOSED)
        for joint, angle in zip(self._joints, joints, strict=True):
            pybullet.resetJointState(self._robot, joint, float(angle), 0.0, **self._on)
        self._tips = self._tips_at(joints)
        for _ in range(SETTLING):
            self.drive(joints, np.zeros(len(joints)))
            self.push_jaws(on_jaws)
            pybullet.applyExternalForce(
                self._robot,
                self._links[self._wrist],
                on_shaft.tolist(),
                place.tolist(),
                pybullet.WORLD_FRAME,
                **self._on,
            )
            reading = self.step()
        return reading.effort[:7]


class TensionBench:
    """Draws trials and lets the estimator judge them.

    Args:
        motion: Scene and limits.
        config: Of the estimator.
    """

    def __init__(self, motion: MotionConfig, config: TorqueTensionConfig) -> None:
        self._config, self._rng = config, np.random.default_rng(11)
        self._planner, self._motion = Planner(load_robot(), motion), motion
        self._text = URDF_FILE.read_text(encoding="utf-8")
        gravity = gravity_in_base(self._planner.model, motion.scene.gravity)
        self._dynamics = InverseDynamics(self._text, 0.0, gravity)
        self._heavier = InverseDynamics(self._text, 1.0, gravity)
        self._trocar = self._planner.trocar
        with quiet():
            home = robot_joints(np.array(motion.scene.home), 0.0)
            self._arm = LoadedArm(URDF_FILE, home, STEP, motion.scene.gravity)

    def close(self) -> None:
        """End PyBullet."""
        self._arm.close()

    def trials(self, count: int) -> Iterator[TensionTrial]:
        """Grasps all over the workspace, each pulled another way."""
        rng, error, made = self._rng, self._config.error, 0
        for pose in random_poses(self._motion, 20 * count, seed=5):
            pull = self._pull()
            moved = pose.copy()
            moved[:3, 3] += pull * rng.uniform(0.0, MAX_WAY)
            first = self._planner.solver.search(pose, self._trocar)
            last = self._planner.solver.settle(first.q, moved, self._trocar)
            if not (first.is_solved and last.is_solved):
                continue
            made += 1
            yield TensionTrial(
                q=np.array([first.q, last.q]),
                pull=pull,
                force=rng.uniform(0.0, MAX_PULL),
                lean=rng.normal(size=2) * LEAN,
                offset=rng.normal(size=7) * error.offset,
                friction=rng.normal(size=(2, 7)) * error.friction,
                gain=1.0 + rng.normal(size=7) * error.gain,
                masses=rng.normal(size=7) * error.model,
                tool_mass=rng.normal() * error.tool_mass,
            )
            if made == count:
                return
        raise RuntimeError(f"only {made} of {count} grasps could be solved")

    def estimate(
        self, trial: TensionTrial, is_tared: bool, has_lean: bool, seal: float = 0.0
    ) -> tuple[float, float, str]:
        """Error [N] and estimated standard deviation [N] of the estimate, and why it is invalid."""
        scene = replace(self._motion.scene, pull_direction=tuple(trial.pull.tolist()))
        estimator = TorqueTension(self._config, self._text, scene)
        now = 0.0
        for stage in (0, 1) if is_tared else (1,):
            motors = self._motors(trial, stage, has_lean, seal)
            joints = robot_joints(trial.q[stage], OPEN if stage == 0 else CLOSED)
            for _ in range(round(WINDOW / PERIOD)):
                now += PERIOD
                noise = self._rng.normal(size=7) * self._config.error.noise
                effort = np.append(motors + noise, np.zeros(3))
                reading = Measurement(joints, np.zeros(10), effort, now, gripped=stage == 1)
                found = estimator.update(reading, self._trocar)
        return found.tension - trial.force, found.sigma, found.tension_invalid_reason

    def ignoring_the_trocar(self, trial: TensionTrial) -> float:
        """Error [N] where a tared estimator takes all load for the pull's."""
        before, under = (self._motors(trial, stage, True, 0.0) for stage in (0, 1))
        seen = under - self._dynamics(trial.q[1]) - before + self._dynamics(trial.q[0])
        errors = TorqueErrors(self._config, self._text, self._motion.scene.gravity)
        A = load_matrix(self._dynamics.model, trial.q[1], self._trocar, trial.pull)
        spread = errors(trial.q[1], A, np.zeros(7), 0.2, None)
        found, *_ = least_squares(A[:, :1], seen, spread)
        return float(found[0]) - trial.force

    def _pull(self) -> Array:
        """The configured way of the pull, turned by up to TURN about a way across it."""
        along = unit_vector(self._motion.scene.pull_direction)
        across = np.cross(along, self._rng.normal(size=3))
        across /= np.linalg.norm(across)
        angle = self._rng.uniform(0.0, TURN)
        turned: Array = np.cos(angle) * along + np.sin(angle) * np.cross(across, along)
        return turned

    def _motors(self, trial: TensionTrial, stage: int, has_lean: bool, seal: float) -> Array:
        """What the arm reports without noise: PyBullet's motors and all that is wrong with them."""
        q = trial.q[stage]
        shaft = Configuration(self._planner.model, q).frames[forward.SHAFT]
        lean = shaft[:, :2] @ trial.lean * (stage == 1 and has_lean)
        drag = -seal * float(shaft[:, 2] @ trial.pull) * shaft[:, 2] * (stage == 1)
        on_jaws = -trial.force * trial.pull * (stage == 1)
        motors = self._arm.torques(q, on_jaws, lean + drag, self._trocar)
        weight = self._heavier(q) - self._dynamics(q)
        motors = motors + trial.masses * self._dynamics(q) + trial.tool_mass * weight
        gained: Array = trial.gain * motors + trial.offset + trial.friction[stage]
        return gained


def measure() -> list[Figure]:
    """Pull in many postures and ways, with a tare and without, with a trocar's load and without."""
    bench = TensionBench(load_motion_config(), load_torque_tension())
    try:
        trials = list(bench.trials(TRIALS))
        cases = {
            name: [bench.estimate(t, is_tared, has_lean) for t in trials]
            for name, is_tared, has_lean in CASES
        }
        ignored = [bench.ignoring_the_trocar(t) for t in trials]
        sealed = [bench.estimate(t, True, True, SEAL)[0] for t in trials]
    finally:
        bench.close()
    figures = [f for name, found in cases.items() for f in _figures(name, found)]
    figures += _spread("tared, trocar taken for no load at all", ignored)
    figures += _spread(f"tared, {SEAL:g} N of friction in the trocar's seal", sealed)
    delay = load_torque_tension().filter_time
    figures.append(Figure("delay of the estimate", delay, "s", note="(of its filter)"))
    return figures


def _figures(name: str, found: Sequence[tuple[float, float, str]]) -> list[Figure]:
    errors, sigmas = [t[0] for t in found], np.array([t[1] for t in found])
    within = int(np.sum(np.abs(errors) <= 2.0 * sigmas))
    is_tared, n = name.startswith("tared"), len(found)
    trusted, target = sum(not t[2] for t in found), None if is_tared else 0.0
    note = "" if is_tared else "nothing is trusted without a tare"
    return [
        *_spread(name, errors),
        Figure(f"{name}: sigma as estimated, median", float(np.median(sigmas)), "N"),
        share(f"{name}: errors within twice the estimated sigma", within, n, 95.0),
        share(f"{name}: trusted", trusted, n, target, at_most=not is_tared, note=note),
        *(_spread(f"{name}, where trusted", [t[0] for t in found if not t[2]]) if trusted else ()),
    ]


def _spread(name: str, errors: Sequence[float]) -> list[Figure]:
    note = f"({len(errors)} postures and ways, 0 to {MAX_PULL:g} N, assumed errors of the arm)"
    return [
        Figure(f"{name}: bias", float(np.mean(errors)), "N", note=note),
        Figure(f"{name}: sigma of the error", float(np.std(errors)), "N"),
        Figure(f"{name}: 95 % of errors below", float(np.quantile(np.abs(errors), 0.95)), "N"),
    ]
