# SPDX-License-Identifier: BSD-3-Clause
"""The remote centre of motion: how far the shaft is from the trocar, and how joints change that."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rst_control.kinematics import forward
from rst_control.kinematics.configuration import Configuration
from rst_control.types import PLAN_COUNT, Vector


@dataclass(frozen=True)
class RcmState:
    """Where the trocar is as seen from the shaft."""

    lateral: tuple[float, float]  # [m], along x and y of interface_link
    insertion: float  # [m] of shaft, up to its wrist, inside the trocar

    @property
    def error(self) -> float:
        """Distance of the shaft line from the trocar [m]."""
        return float(np.hypot(*self.lateral))


def rcm_error(p_shaft: Vector, d_shaft: Vector, p_rcm: Vector) -> Vector:
    """Vector from the shaft line to the trocar.

    Args:
        p_shaft: Any point of the shaft, base frame, [m]. Shape (3,).
        d_shaft: Unit direction of the shaft, base frame. Shape (3,).
        p_rcm: Trocar, base frame, [m]. Shape (3,).

    Returns:
        Shortest such vector, base frame, [m]. Shape (3,).
    """
    offset = p_rcm - p_shaft
    # Twice: the first pass leaves a rounding error that grows with the distance along the shaft.
    for _ in range(2):
        offset = offset - d_shaft * float(d_shaft @ offset)
    return offset


def rcm_state(configuration: Configuration, trocar: Vector) -> RcmState:
    """Where the trocar (3,), base frame, [m], is as seen from the shaft."""
    x, y, along = forward.rcm_offset(configuration.frames, trocar)
    return RcmState((x, y), configuration.model.shaft_length - along)


def rcm_jacobian(configuration: Configuration, trocar: Vector) -> NDArray[np.float64]:
    """Derivative of `RcmState.lateral` by q [m/rad]. Shape (2, 9)."""
    J = np.empty((2, PLAN_COUNT))
    forward.rcm_jacobian(configuration.frames, trocar, J)
    return J
