# SPDX-License-Identifier: BSD-3-Clause
"""How wrong joint torques may be: the covariance of what they show beyond the model."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rst_control.config.torque_tension import TorqueTensionConfig
from rst_control.kinematics import forward
from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.inverse_dynamics import InverseDynamics
from rst_control.kinematics.mounting import gravity_in_base
from rst_control.kinematics.robot_model import parse_robot
from rst_control.tension.torque_bias import Tare
from rst_control.types import ARM_COUNT, Vector

Array = NDArray[np.float64]
HEAVIER = 0.1  # [kg] by which the tool is made heavier to find what its weight asks of the joints
LEAST = 1e-4  # [N m] that no torque is known better than


class TorqueErrors:
    """Model of the robot as it is mounted, and the covariance of its torques at a posture.

    Args:
        config: Mass of the tool; standard deviations of each source of errors.
        description: URDF text of the robot.
        setting: `scene.gravity`; empty: as the URDF has it.

    Raises:
        RobotModelError: The URDF is not this robot's, or says another way of gravity.
    """

    def __init__(
        self, config: TorqueTensionConfig, description: str, setting: Sequence[float] = ()
    ) -> None:
        mass, gravity = config.tool_mass, gravity_in_base(parse_robot(description), setting)
        self._error = config.error
        self.dynamics = InverseDynamics(description, mass, gravity)
        self._heavier = InverseDynamics(description, mass + HEAVIER, gravity)
        g = float(np.linalg.norm(gravity))
        self._across = np.linalg.svd(gravity[None, :] / g)[2][1:].T  # (3, 2), square to gravity
        self._axes = [InverseDynamics(description, mass, g * axis) for axis in np.eye(3)]

    def __call__(
        self, q: Vector, A: Array, asked: Vector, noise_share: float, tare: Tare | None
    ) -> Array:
        """Covariance of the torques beyond the model.

        It does not depend on these torques. Were a joint that happens to read more trusted less,
        all pulls would be estimated too small. Instead it assumes `loads` on the jaws and shaft.

        Args:
            q: Planning configuration [rad]. Shape (9,).
            A: Torques per newton of pull and of both forces across the shaft [N m/N]. Shape (7, 3).
            asked: Torques that the motion asks for beyond holding still [N m]. Shape (7,).
            noise_share: Variance of the filtered over that of one reading.
            tare: In force; None: there is none.

        Returns:
            [(N m)^2]. Shape (7, 7).
        """
        error, pull, lean = self._error, *self._error.loads
        gravity, weight, friction = self.dynamics(q), self._of_tool(q), np.array(error.friction)
        tilt = error.tilt * self.of_gravity(q) @ self._across
        if tare is not None:  # what is wrong alike at both postures is gone
            noise_share += tare.noise_share
            gravity = gravity - self.dynamics(tare.q)
            weight = weight - self._of_tool(tare.q)
            tilt = tilt - error.tilt * self.of_gravity(tare.q) @ self._across
            friction = np.sqrt(2.0) * friction  # it may have been the other way round
        parts = [
            np.sqrt(noise_share) * np.array(error.noise),
            friction,
            error.gain * gravity,
            *(error.gain * A * (pull, lean, lean)).T,
            error.model * gravity,
            error.inertia * asked,
            np.full(ARM_COUNT, LEAST),
        ]
        if tare is None:
            parts.append(np.array(error.offset))
        square = sum(part * part for part in parts)
        tool = error.tool_mass * weight
        spread: Array = np.diag(square) + np.outer(tool, tool) + tilt @ tilt.T
        return spread

    def along_shaft(self, q: Vector, pull: Vector) -> float:
        """Standard deviation of the pull [N] that friction of the trocar on the shaft makes."""
        shaft = Configuration(self.dynamics.model, q).frames[forward.SHAFT, :, 2]
        return self._error.trocar_friction * abs(float(shaft @ pull))

    def _of_tool(self, q: Vector) -> Vector:
        """Torques that a kilogram at the tool asks for [N m/kg]. Shape (7,)."""
        per_kg: Vector = (self._heavier(q) - self.dynamics(q)) / HEAVIER
        return per_kg

    def of_gravity(self, q: Vector) -> Array:
        """Torques that gravity along each axis of the base asks for [N m]. Shape (7, 3)."""
        return np.column_stack([along(q) for along in self._axes])
