# SPDX-License-Identifier: BSD-3-Clause
"""The tissue's pull on the jaws, estimated from the torques of the arm's joints.

What the torques show beyond gravity and inertia comes from the tissue at the jaws and from the
trocar on the shaft. Both are solved for at once, the first along the known way of the pull, the
second as two forces across the shaft, so that a shaft that leans on its trocar does not read as
tension. Friction along the shaft acts where the pull acts and cannot be separated from it.

Weighted least squares with all known errors, or Gauss-Markov: A. C. Aitken, On Least Squares and
Linear Combination of Observations, Proc. Royal Society of Edinburgh 55, 1936.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, cos, degrees, exp, inf, radians, sqrt

import numpy as np
from numpy.typing import NDArray

from rst_control.config import SceneConfig
from rst_control.config.torque_tension import TorqueTensionConfig
from rst_control.kinematics import forward
from rst_control.kinematics.configuration import Configuration, planning_joints
from rst_control.kinematics.robot_model import RobotModel
from rst_control.tension.gravity_check import GravityCheck
from rst_control.tension.torque_bias import Tare, TareTaker
from rst_control.tension.torque_covariance import TorqueErrors
from rst_control.types import ARM_COUNT, Measurement, Vector, frozen_array, unit_vector
from typed_config import require

Array = NDArray[np.float64]
INVERTED = 0.3  # share of the excess that is left where efforts have the other sign
MOVED = 3e-3  # [m] of the tip since the grasp, from where the way of the pull shows
OFF = radians(20.0)  # of that way from the one along which tension is estimated; hides 6 % of it


@dataclass(frozen=True, eq=False)
class TensionEstimate:
    """What the torques say at one moment."""

    tension: float  # [N] pull of the tissue along the known way; negative: a push
    sigma: float  # [N] standard deviation
    lateral: Vector  # (2,), [N] of the trocar on the shaft, along x and y of interface_link
    force: Vector  # (3,), [N] of the tissue on the jaws, base frame
    tension_invalid_reason: str  # why it must not be relied on, with value and limit; empty: it may


class TorqueTension:
    """Filters torques and estimates the tension from them, one reading after the other.

    Behind a steady rise the estimate is late by `filter_time`.

    Args:
        config: Filter, errors, and what is not trusted.
        description: URDF text of the robot.
        scene: Its way of the pull and its gravity count.

    Raises:
        RobotModelError: The URDF is not this robot's, or says another way of gravity.
        ConfigError: The scene leaves the way of the pull open.
    """

    def __init__(self, config: TorqueTensionConfig, description: str, scene: SceneConfig) -> None:
        allowed = "three numbers: joint torques show tension along a known way only"
        require(bool(scene.pull_direction), "scene.pull_direction", [], allowed)
        self._config = config
        self._errors = TorqueErrors(config, description, scene.gravity)
        self._dynamics = self._errors.dynamics
        self._check = GravityCheck(self._errors, config.max_misfit)
        self._misfit = ""  # why the bias of the tare is not one; empty: it may be
        self._pull = frozen_array(unit_vector(scene.pull_direction), 3)
        self._grasped_at: Vector | None = None  # tip; None: nothing is held
        self._tares = TareTaker(config.tare, config.filter_time)
        self._last: Measurement | None = None
        self._excess, self._asked = np.zeros(ARM_COUNT), np.zeros(ARM_COUNT)  # filtered [N m]
        self._noise_share, self._readings = 1.0, 0

    def update(self, measured: Measurement, trocar: Vector) -> TensionEstimate:
        """Take in one reading; one that is no newer than the last is passed over.

        Args:
            measured: With the torques that the motors give as effort [N m].
            trocar: Remote centre of motion, base frame, [m]. Shape (3,).
        """
        q, opening = planning_joints(measured.position)
        last = self._last
        if last is None or measured.stamp > last.stamp:
            self._last = measured
            self._filter(measured, last, q)
            before = self._tares.tare
            self._tares.update(measured, opening, self._excess, self._noise_share)
            tare = self._tares.tare
            if tare is not None and tare is not before:
                self._misfit = self._check.objection(tare.q, tare.bias, tare.noise_share)
        if not measured.gripped:
            self._grasped_at = None
        elif self._grasped_at is None:
            self._grasped_at = Configuration(self._dynamics.model, q).tip
        A = load_matrix(self._dynamics.model, q, trocar, self._pull)
        return self._solve(A, measured, q)

    def _filter(self, measured: Measurement, last: Measurement | None, q: Vector) -> None:
        span = inf if last is None else measured.stamp - last.stamp
        is_anew = last is None or span > self._config.gap
        dq, _ = planning_joints(measured.velocity)
        before = dq if last is None or is_anew else planning_joints(last.velocity)[0]
        ddq = np.zeros_like(q) if is_anew else (dq - before) / span
        model = self._dynamics(q, dq, ddq)
        effort = self._config.effort_sign * measured.effort[:ARM_COUNT]
        excess, asked = effort - model, model - self._dynamics(q)
        if is_anew:
            self._tares.forget_start()
            self._excess, self._asked = excess, asked
            self._noise_share, self._readings = 1.0, 1
            return
        time = self._config.filter_time
        new = 1.0 if time <= 0.0 else 1.0 - exp(-span / time)
        self._excess = self._excess + new * (excess - self._excess)
        self._asked = self._asked + new * (asked - self._asked)
        self._noise_share = (1.0 - new) ** 2 * self._noise_share + new * new
        self._readings += 1

    def _solve(self, A: Array, measured: Measurement, q: Vector) -> TensionEstimate:
        tare, last = self._tares.valid(measured.stamp, q), self._tares.tare
        # One that holds no more is nearer than none: the watchdogs act on what is not trusted, too.
        seen = self._excess - (last.bias if last else 0.0)
        spread = self._errors(q, A, self._asked, self._noise_share, tare)
        found, covariance, misfit = least_squares(A, seen, spread)
        along = self._errors.along_shaft(q, self._pull)
        sigma = sqrt(float(covariance[0, 0]) + along * along)
        tension = float(found[0])
        invalid = self._invalid_reason(measured, q, sigma, misfit, tare)
        lateral, force = frozen_array(found[1:], 2), frozen_array(-tension * self._pull, 3)
        return TensionEstimate(tension, sigma, lateral, force, invalid)

    def _invalid_reason(
        self, measured: Measurement, q: Vector, sigma: float, misfit: float, tare: Tare | None
    ) -> str:
        config, speed = self._config, np.abs(measured.velocity[:ARM_COUNT])
        if self._readings < config.min_readings:
            return f"only {self._readings} torque readings so far, at least {config.min_readings}"
        if self._looks_inverted(q):
            return "torques are those of gravity with the other sign: change effort_sign"
        if tare is None:
            return self._tares.why_none(measured.stamp, q)
        if self._misfit:
            return self._misfit
        joint = int(speed.argmax())
        if speed[joint] > config.fastest:
            return (
                f"joint_{joint + 1} at {speed[joint]:.2f} rad/s, too fast to estimate tension from "
                f"torques, allowed {config.fastest:.2f}"
            )
        if words := self._other_way(q):
            return words
        if sigma > config.max_sigma:
            return f"tension known to {sigma:.2f} N only, allowed {config.max_sigma:.2f} N"
        if not misfit <= config.max_misfit:
            return (
                f"torques fit no pull at the jaws: misfit {misfit:.0f}, allowed "
                f"{config.max_misfit:.0f}; something else pushes the arm"
            )
        return ""

    def _other_way(self, q: Vector) -> str:
        """Why the tissue is pulled another way than estimated along; empty: it is not."""
        if self._grasped_at is None:
            return ""
        moved = Configuration(self._dynamics.model, q).tip - self._grasped_at
        way, along = float(np.linalg.norm(moved)), float(moved @ self._pull)
        if way < MOVED or along >= cos(OFF) * way:
            return ""
        return (
            f"the tip moved {degrees(acos(along / way)):.0f} deg off scene.pull_direction since "
            f"the grasp, allowed {degrees(OFF):.0f}: tension is known along it only"
        )

    def _looks_inverted(self, q: Vector) -> bool:
        """Whether what was measured is gravity's torque with the other sign."""
        other = self._excess + 2.0 * self._dynamics(q)
        return float(np.linalg.norm(other)) < INVERTED * float(np.linalg.norm(self._excess))


def load_matrix(model: RobotModel, q: Vector, trocar: Vector, pull: Vector) -> Array:
    """Torques that the motors give against a pull of 1 N, and against 1 N across the shaft.

    Args:
        model: The robot.
        q: Planning configuration [rad]. Shape (9,).
        trocar: Base frame, [m]. Shape (3,).
        pull: Unit vector along which the jaws pull, base frame. Shape (3,).

    Returns:
        Columns: pull, trocar along x and along y of interface_link [N m/N]. Shape (7, 3).
    """
    here = Configuration(model, q)
    J_tip = here.J_tip[:3, :ARM_COUNT]
    axes, places = here.frames[:ARM_COUNT, :, 2], here.frames[:ARM_COUNT, :, 3]
    J_trocar = np.cross(axes, trocar - places).T  # of the shaft, there
    shaft = here.frames[forward.SHAFT]
    # Against the tissue's force -t * pull on the jaws the motors give +t * J^T pull; against the
    # trocar's force f on the shaft, -J^T f.
    return np.column_stack([J_tip.T @ pull, -J_trocar.T @ shaft[:, :2]])


def least_squares(A: Array, seen: Vector, spread: Array) -> tuple[Vector, Array, float]:
    """Best unbiased solution x of A x = seen, where seen has the covariance `spread`.

    Args:
        A: Shape (m, n).
        seen: Shape (m,).
        spread: Positive definite. Shape (m, m).

    Returns:
        x (n,), its covariance (n, n), and the chi-square of what is left over.
    """
    L = np.linalg.cholesky(spread)
    W, y = np.linalg.solve(L, A), np.linalg.solve(L, seen)
    covariance = np.linalg.inv(W.T @ W)
    x = covariance @ (W.T @ y)
    left = y - W @ x
    return x, covariance, float(left @ left)
