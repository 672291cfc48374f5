# SPDX-License-Identifier: BSD-3-Clause
"""How freely the joints move the tool with the shaft through the trocar."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from rst_control.errors import NearSingular
from rst_control.kernels import kernel
from rst_control.kinematics import constrained_ik
from rst_control.kinematics import forward as kin
from rst_control.types import Vector

Array = NDArray[np.float64]
STRIDE: Final = 10  # places between two evaluations, where the measure is far from its limit
FAR: Final = 2.0  # times the limit; between knots of a path the measure changes by some percent


@kernel
def measure(chain: Any, q: Any, trocar: Any) -> float:
    """Manipulability at q (9,) under the eight constraints of trocar (2) and tool pose (6).

    It is sqrt(det(J J^T)), the product of J's singular values, which is zero where some motion of
    the tool is lost. J is `constrained_ik.constraints`: rows of metres per radian, where a radian
    of the tool counts as 0.1 m. Source: T. Yoshikawa, Manipulability of Robotic Mechanisms, Int.
    J. Robotics Research 4 (2), 1985.
    """
    frames, J, L = np.empty((12, 3, 4)), np.zeros((8, 9)), np.zeros((8, 8))
    kin.forward(chain, q, frames)
    constrained_ik.constraints(frames, trocar, J)
    constrained_ik.factor(J, 0.0, L)
    product = 1.0
    for i in range(constrained_ik.ROWS):
        product *= L[i, i]
    return product


@kernel
def _minimum(chain: Any, q: Any, trocar: Any, stride: int) -> float:
    least = measure(chain, q[len(q) - 1], trocar)
    for k in range(0, len(q), stride):
        value = measure(chain, q[k], trocar)
        if not value >= least:
            least = value
        if np.isnan(value):
            return value
    return least


def check(chain: Array, q: Array, trocar: Vector, allowed: float) -> None:
    """Check joints along a way.

    Args:
        chain: Of the robot.
        q: Joints [rad], near to each other. Shape (n, 9).
        trocar: Base frame, [m]. Shape (3,).
        allowed: Least manipulability, see `measure`.

    Raises:
        NearSingular: It is less somewhere; names the least.
    """
    joints = np.ascontiguousarray(q)
    least = _minimum(chain, joints, trocar, STRIDE)
    if not least >= FAR * allowed:
        least = _minimum(chain, joints, trocar, 1)
    if not least >= allowed:  # no number: refused, too
        raise NearSingular(least, allowed)
