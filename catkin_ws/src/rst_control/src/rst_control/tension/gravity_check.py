# SPDX-License-Identifier: BSD-3-Clause
"""Whether the torques of an arm at rest are those of gravity, as mounting and masses are set.

An arm on a wall whose settings have it upright shows torques that no pull explains. A tare would
hide that where it is taken, and give a wrong tension a little further on.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from rst_control.config.torque_tension import TorqueTensionConfig
from rst_control.kinematics.configuration import planning_joints
from rst_control.kinematics.mounting import angle_between, way_words
from rst_control.tension.torque_covariance import TorqueErrors
from rst_control.types import ARM_COUNT, Vector

Array = NDArray[np.float64]
READINGS: Final = 20  # that are averaged, of an arm at rest
MAX_BY_TILT: Final = 12.0  # [-] chi-square that another gravity explains: 0.7 % by chance
MIN_GRAVITY: Final = 0.1  # [-] share of gravity that torques show at least where it has a way
OPPOSITE: Final = 170.0  # [deg] from which torques of the other sign explain as much as a mounting
NO_LOADS: Final = np.zeros((ARM_COUNT, 3))


class GravityCheck:
    """Compares torques at rest with gravity's, each joint within all that may be wrong with it.

    Args:
        errors: Model of the robot as it is mounted, and what may be wrong with its torques.
        max_misfit: Chi-square that is allowed [-].
    """

    def __init__(self, errors: TorqueErrors, max_misfit: float) -> None:
        self._errors, self._allowed = errors, max_misfit

    def objection(self, q: Vector, excess: Vector, noise_share: float) -> str:
        """Why these are not gravity's torques; empty: they are.

        Args:
            q: Planning configuration [rad]. Shape (9,).
            excess: Torques beyond those of the model [N m]. Shape (7,).
            noise_share: Variance of these over that of one reading.
        """
        spread = self._errors(q, NO_LOADS, np.zeros(ARM_COUNT), noise_share, None)
        G, gravity = self._errors.of_gravity(q), self._errors.dynamics.gravity
        misfit, by_tilt = float(excess @ np.linalg.solve(spread, excess)), _share(G, excess, spread)
        if misfit <= self._allowed and by_tilt <= MAX_BY_TILT:
            return ""
        model = self._errors.dynamics(q)
        joint = int(np.abs(excess / np.sqrt(np.diag(spread))).argmax())
        way: Vector = np.linalg.lstsq(G, model + excess, rcond=None)[0].astype(float)
        nearest = "They are too small for any gravity"
        if np.linalg.norm(way) > MIN_GRAVITY:
            angle = np.degrees(angle_between(way, gravity))
            nearest = f"Nearest is {way_words(way)}, {angle:.0f} deg from it"
            if angle > OPPOSITE:
                nearest += ". If the base is not mounted so, the sign is wrong: effort_sign"
        return (
            f"torques at rest do not fit gravity along {way_words(gravity)}: joint_{joint + 1} "
            f"gives {model[joint] + excess[joint]:.2f} N m, expected {model[joint]:.2f} (misfit "
            f"{misfit:.0f}, allowed {self._allowed:.0f}; by a tilt {by_tilt:.0f}, allowed "
            f"{MAX_BY_TILT:.0f}). {nearest}: check scene.gravity, the root of the URDF, the "
            "payload and effort_sign"
        )


def _share(G: Array, excess: Vector, spread: Array) -> float:
    """Chi-square of an excess (7,) that another gravity (3,) explains, G being of shape (7, 3)."""
    L = np.linalg.cholesky(spread)
    W, y = np.linalg.solve(L, G), np.linalg.solve(L, excess)
    explained = W @ np.linalg.lstsq(W, y, rcond=None)[0]
    return float(explained @ explained)


class RestTorques:
    """Averages the torques of an arm at rest and checks them once; `refusal` until they fit.

    Args:
        config: Errors, sign and payload.
        description: URDF text of the robot.
        setting: `scene.gravity`.

    Raises:
        RobotModelError: The URDF is not this robot's, or says another way of gravity.
    """

    def __init__(
        self, config: TorqueTensionConfig, description: str, setting: tuple[float, ...]
    ) -> None:
        errors = TorqueErrors(config, description, setting)
        self._config, self._dynamics = config, errors.dynamics
        self._check = GravityCheck(errors, config.max_misfit)
        self._sum, self._count = np.zeros(ARM_COUNT), 0
        self.refusal = "torques at rest were not compared with gravity's yet: rest, with empty jaws"

    def update(self, position: Vector, velocity: Vector, effort: Vector) -> None:
        """Take in one reading; nothing is done once they fit.

        Args:
            position: Of all ten joints [rad]. Shape (10,).
            velocity: Of the arm's joints [rad/s]. Shape (7,).
            effort: As reported [N m]. Shape (7,).
        """
        if not self.refusal:
            return
        if np.abs(velocity).max() > self._config.tare.at_rest_speed:
            self._sum, self._count = np.zeros(ARM_COUNT), 0
            return
        q = planning_joints(position)[0]
        excess = self._config.effort_sign * effort - self._dynamics(q)
        self._sum, self._count = self._sum + excess, self._count + 1
        if self._count >= READINGS:
            self.refusal = self._check.objection(q, self._sum / self._count, 1.0 / self._count)
            self._sum, self._count = np.zeros(ARM_COUNT), 0
