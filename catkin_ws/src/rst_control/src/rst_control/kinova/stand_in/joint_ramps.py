# SPDX-License-Identifier: BSD-3-Clause
"""Each joint changes its speed by itself, within an acceleration: nothing keeps them on a path."""

from __future__ import annotations

import numpy as np

from rst_control.types import Vector


def ramped(speed: Vector, wanted: Vector, acceleration: Vector, time: float) -> Vector:
    """Speeds [rad/s] after a time [s] on the way to those wanted; shape (7,)."""
    most = acceleration * time
    return speed + np.clip(wanted - speed, -most, most)


def fastest_towards_limits(
    position: Vector, lower: Vector, upper: Vector, braking: Vector, step: float
) -> tuple[Vector, Vector]:
    """Speeds from which every joint can still stop before its limits.

    From distance d the speed v stops in time where v^2 / (2 a) + v t <= d, t being one step.

    Args:
        position: [rad]. Shape (7,).
        lower: [rad]. Shape (7,).
        upper: [rad]. Shape (7,).
        braking: [rad/s^2]. Shape (7,).
        step: Time between two calls [s].

    Returns:
        Lowest (negative) and highest speed [rad/s], shapes (7,).
    """

    def most(distance: Vector) -> Vector:
        room = np.maximum(distance, 0.0)
        lost = braking * step
        return np.sqrt(lost**2 + 2.0 * braking * room) - lost

    return -most(position - lower), most(upper - position)
