# SPDX-License-Identifier: BSD-3-Clause
"""The remote centre of motion (RCM): the shaft has to pass through the trocar.

The shaft is the z axis of interface_link. Seen from there, the trocar has a lateral offset (x, y);
the constraint is that it is zero. `rcm_offset` and `rcm_jacobian` are compiled: every solver, path
check and watchdog takes the constraint from them. `rcm_error_vector` is the definition to read.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from rst_control.kernels import kernel
from rst_control.kinematics import forward
from rst_control.kinematics.configuration import Configuration
from rst_control.types import Vector


def rcm_error_vector(p_shaft: Vector, d_shaft: Vector, p_rcm: Vector) -> Vector:
    """Vector from the shaft line to the trocar: the definition that the kernels are tested against.

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


@kernel
def rcm_offset(frames: Any, trocar: Any) -> tuple[float, float, float]:
    """Where the trocar (3,) is in the shaft's frame [m]: lateral x and y, then along the shaft.

    The constraint is that x and y are zero.
    """
    ox = trocar[0] - frames[forward.SHAFT, 0, 3]
    oy = trocar[1] - frames[forward.SHAFT, 1, 3]
    oz = trocar[2] - frames[forward.SHAFT, 2, 3]
    f = frames[forward.SHAFT]
    return (
        f[0, 0] * ox + f[1, 0] * oy + f[2, 0] * oz,
        f[0, 1] * ox + f[1, 1] * oy + f[2, 1] * oz,
        f[0, 2] * ox + f[1, 2] * oy + f[2, 2] * oz,
    )


@kernel
def rcm_jacobian(frames: Any, trocar: Any, J: Any) -> None:
    """Write the derivative of lateral x and y by q [m/rad] into J (2, 9).

    In the shaft's frame the trocar moves with minus the velocity that the shaft has at the trocar.
    """
    f = frames[forward.SHAFT]
    for i in range(7):
        x, y, z = frames[i, 0, 2], frames[i, 1, 2], frames[i, 2, 2]
        dx = trocar[0] - frames[i, 0, 3]
        dy = trocar[1] - frames[i, 1, 3]
        dz = trocar[2] - frames[i, 2, 3]
        vx, vy, vz = y * dz - z * dy, z * dx - x * dz, x * dy - y * dx
        J[0, i] = -(f[0, 0] * vx + f[1, 0] * vy + f[2, 0] * vz)
        J[1, i] = -(f[0, 1] * vx + f[1, 1] * vy + f[2, 1] * vz)
    J[0, 7] = J[0, 8] = J[1, 7] = J[1, 8] = 0.0


@dataclass(frozen=True)
class RcmState:
    """Where the trocar is as seen from the shaft."""

    lateral: tuple[float, float]  # [m], along x and y of interface_link
    insertion: float  # [m] of shaft, up to its wrist, inside the trocar

    @property
    def error(self) -> float:
        """Distance of the shaft line from the trocar [m]."""
        return float(np.hypot(*self.lateral))


def rcm_state(configuration: Configuration, trocar: Vector) -> RcmState:
    """Where the trocar (3,), base frame, [m], is as seen from the shaft."""
    x, y, along = rcm_offset(configuration.frames, trocar)
    return RcmState((x, y), configuration.model.shaft_length - along)
