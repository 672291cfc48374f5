# SPDX-License-Identifier: BSD-3-Clause
"""Motors that follow their course against friction: they stick, break loose and slip.

Of each motor, seen at its joint: B a = B (w^2 e + 2 w e' + c w^3 I) - f - (1 - known) load, where
e is what it is behind its course, I the integral of e, and f the friction: up to the static one at
rest, and sliding + (static - sliding) exp(-(v / v_s)^2) + viscous v in motion (Stribeck's curve,
Armstrong-Helouvry, Dupont and Canudas de Wit 1994). Each step takes the friction as an impulse that
can stop a motor and never turns it back (Moreau 1988), so that a motor truly rests.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from rst_control.config.plant import DrivesConfig
from rst_control.kernels import kernel
from rst_control.types import Vector

SUBSTEPS: Final = 10  # of a step of the physics


class Drives:
    """The motors of the arm.

    Args:
        config: Inertia, servo and friction.
        position: Where they begin [rad]. Shape (7,).
        step: Time of one `advance` [s].
    """

    def __init__(self, config: DrivesConfig, position: Vector, step: float) -> None:
        self.position, self.velocity = np.array(position), np.zeros(len(position))
        self._integral = np.zeros(len(position))
        self._step, self._unknown = step / SUBSTEPS, 1.0 - config.load_known
        self._settings = np.array(
            [
                config.inertia,
                config.bandwidth,
                config.integral,
                config.static_friction,
                config.sliding_friction,
                config.viscous_friction,
                [config.stribeck_speed] * len(position),
            ]
        )

    def advance(self, course: Vector, speed: Vector, load: Vector) -> None:
        """Move on by one step.

        Args:
            course: Where the motors should be at its end [rad]. Shape (7,).
            speed: Of the course [rad/s]. Shape (7,).
            load: Torques that hold the joints against their load [N m]. Shape (7,).
        """
        state = (self.position, self.velocity, self._integral)
        unknown = self._unknown * load
        _advance(*state, course, speed, unknown, self._settings, self._step, SUBSTEPS)


@kernel
def _advance(
    position: Any,
    velocity: Any,
    integral: Any,
    course: Any,
    speed: Any,
    load: Any,
    settings: Any,
    step: float,
    count: int,
) -> None:
    for j in range(len(position)):
        B, w, c, static, sliding, viscous, stribeck = settings[:, j]
        for n in range(count):
            goal = course[j] - speed[j] * step * (count - n)
            error = goal - position[j]
            integral[j] += error * step
            servo = w * w * error + 2.0 * w * (speed[j] - velocity[j]) + c * w**3 * integral[j]
            v = velocity[j] + step * (servo - load[j] / B)
            friction = static
            if velocity[j] != 0.0:
                slip = (velocity[j] / stribeck) ** 2
                friction = sliding + (static - sliding) * np.exp(-slip) + viscous * abs(velocity[j])
            lost = step * friction / B
            if abs(v) <= lost:
                v = 0.0
            elif v > 0.0:
                v -= lost
            else:
                v += lost
            velocity[j] = v
            position[j] += step * v
