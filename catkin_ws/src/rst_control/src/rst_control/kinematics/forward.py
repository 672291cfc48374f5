# SPDX-License-Identifier: BSD-3-Clause
"""Compiled kinematics of the arm and tool: frames and Jacobians in a microsecond.

KDL is the reference that these kernels are tested against. A `Chain` holds 12 fixed transforms and
a row of locks as (13, 3, 4): rows 0 to 8 place each moving joint behind the one before it, then
interface_link and tool0 behind joint_7, and tool_tip behind the left finger. `frames` holds where
they are, base frame, in the same order, (12, 3, 4).

An arm with fewer than seven joints has locked ones in the place of those that it lacks. A locked
joint turns nothing, whatever its angle, and its axis is zero: so are its columns of all Jacobians,
no solver moves it, and the direction in which joints are free is the locked joint's own.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rst_control.kernels import kernel

Array = NDArray[np.float64]

SHAFT, TOOL0, TIP = 9, 10, 11  # rows of `frames` beside the 9 moving joints
LOCKS = 12  # row of a chain: 1 for each joint 0 to 8 that is locked, row by row
ELBOW = 3  # row of joint_4
PITCH = 7  # row of the pitch joint: far end of the shaft


@kernel
def _place(frames: Any, parent: int, chain: Any, k: int) -> None:
    for i in range(3):
        a, b, c = frames[parent, i, 0], frames[parent, i, 1], frames[parent, i, 2]
        for j in range(4):
            frames[k, i, j] = a * chain[k, 0, j] + b * chain[k, 1, j] + c * chain[k, 2, j]
        frames[k, i, 3] += frames[parent, i, 3]


@kernel
def _turn(frames: Any, k: int, angle: float) -> None:
    c, s = np.cos(angle), np.sin(angle)
    for i in range(3):
        x, y = frames[k, i, 0], frames[k, i, 1]
        frames[k, i, 0] = c * x + s * y
        frames[k, i, 1] = c * y - s * x


@kernel
def _is_locked(chain: Any, k: int) -> bool:
    return chain[LOCKS, k // 4, k % 4] != 0.0


@kernel
def forward(chain: Any, q: Any, frames: Any) -> None:
    """Write all frames at q into `frames` (12, 3, 4)."""
    for i in range(3):
        for j in range(4):
            frames[0, i, j] = chain[0, i, j]
    if not _is_locked(chain, 0):
        _turn(frames, 0, q[0])
    for k in range(1, 9):
        _place(frames, k - 1, chain, k)
        if not _is_locked(chain, k):
            _turn(frames, k, q[k])
    _place(frames, 6, chain, SHAFT)
    _place(frames, 6, chain, TOOL0)
    _place(frames, 8, chain, TIP)
    for k in range(9):  # last: other frames were placed behind these
        if _is_locked(chain, k):
            for i in range(3):
                frames[k, i, 2] = 0.0


@kernel
def tip_jacobian(frames: Any, scale: float, J: Any) -> None:
    """Write the tip's Jacobian, base frame, into J (6, 9): metres, then radians times `scale`."""
    px, py, pz = frames[TIP, 0, 3], frames[TIP, 1, 3], frames[TIP, 2, 3]
    for i in range(9):
        x, y, z = frames[i, 0, 2], frames[i, 1, 2], frames[i, 2, 2]
        dx, dy, dz = px - frames[i, 0, 3], py - frames[i, 1, 3], pz - frames[i, 2, 3]
        J[0, i] = y * dz - z * dy
        J[1, i] = z * dx - x * dz
        J[2, i] = x * dy - y * dx
        J[3, i] = x * scale
        J[4, i] = y * scale
        J[5, i] = z * scale


@kernel
def turn_between(a: Any, b: Any, out: Any) -> None:
    """Write the rotation vector [rad], base frame, that turns frame a (3, 3+) into frame b."""
    t = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            t[i, j] = b[i, 0] * a[j, 0] + b[i, 1] * a[j, 1] + b[i, 2] * a[j, 2]
    out[0] = 0.5 * (t[2, 1] - t[1, 2])
    out[1] = 0.5 * (t[0, 2] - t[2, 0])
    out[2] = 0.5 * (t[1, 0] - t[0, 1])
    sine = np.sqrt(out[0] ** 2 + out[1] ** 2 + out[2] ** 2)
    cosine = 0.5 * (t[0, 0] + t[1, 1] + t[2, 2] - 1.0)
    if sine > 1e-9:
        scale = np.arctan2(sine, cosine) / sine
        for i in range(3):
            out[i] *= scale
    elif cosine < 0.0:  # half a turn: the axis is the column of t + 1 with the largest diagonal
        k = 0
        for i in range(1, 3):
            if t[i, i] > t[k, k]:
                k = i
        norm = np.sqrt(max(2.0 * (t[k, k] + 1.0), 1e-300))
        for i in range(3):
            out[i] = np.pi * (t[i, k] + (1.0 if i == k else 0.0)) / norm
