# SPDX-License-Identifier: BSD-3-Clause
"""Compiled continuation: joint angles and true derivatives at the knots of a straight tool motion.

The elbow's swing is prescribed along the way, so that nine conditions fix nine joints and q(s) is
smooth: the joint change along one fixed direction, `swing_axis`, grows in proportion to s up to
`swing`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from rst_control.kernels import kernel
from rst_control.kinematics import constrained_ik
from rst_control.kinematics import forward as kin

MAX_ITERATIONS = 12  # at one knot; it takes 2 to 4
SWING_TOLERANCE = 1e-10  # [rad]
LOST = 1.0  # [m] that is missing where the steps went astray, or the elbow cannot swing
MIN_ALIGNMENT = 0.1  # [-] of swing axis and free direction, below which the elbow is stuck


@kernel
def free_direction(chain: Any, q: Any, trocar: Any, is_straight: bool, out: Any) -> None:
    """Write the unit joint direction (9,) that moves neither tool nor shaft."""
    frames, J, L = np.empty((12, 3, 4)), np.zeros((8, 9)), np.zeros((8, 8))
    kin.forward(chain, q, frames)
    constrained_ik.constraints(frames, trocar, J)
    if is_straight:
        constrained_ik.hold_wrist(q, np.empty(8), J)
    constrained_ik.factor(J, 0.0, L)
    best = 0.0
    trial, found = np.zeros(9), np.empty(9)
    for j in range(9):
        trial[:] = 0.0
        trial[j] = 1.0
        constrained_ik.project(J, L, trial, found)
        norm = 0.0
        for i in range(9):
            norm += found[i] * found[i]
        if norm > best:
            best = norm
            for i in range(9):
                out[i] = found[i] / np.sqrt(norm)


@kernel
def pose_between(start: Any, shift: Any, turn: Any, share: float, out: Any) -> None:
    """Write start (3, 4), moved by a share of shift [m] and turn [rad], base frame, into out."""
    angle = share * np.sqrt(turn[0] ** 2 + turn[1] ** 2 + turn[2] ** 2)
    c = np.cos(angle)
    if angle > 1e-12:
        x, y, z = turn[0] * share / angle, turn[1] * share / angle, turn[2] * share / angle
    else:
        x, y, z = 0.0, 0.0, 0.0
    s, d = np.sin(angle), 1.0 - c
    R = np.empty((3, 3))
    R[0, 0], R[0, 1], R[0, 2] = c + d * x * x, d * x * y - s * z, d * x * z + s * y
    R[1, 0], R[1, 1], R[1, 2] = d * x * y + s * z, c + d * y * y, d * y * z - s * x
    R[2, 0], R[2, 1], R[2, 2] = d * x * z - s * y, d * y * z + s * x, c + d * z * z
    for i in range(3):
        for j in range(3):
            out[i, j] = R[i, 0] * start[0, j] + R[i, 1] * start[1, j] + R[i, 2] * start[2, j]
        out[i, 3] = start[i, 3] + share * shift[i]


@kernel
def _with_swing(dq: Any, free: Any, axis: Any, wanted: float) -> None:
    along, done = 0.0, 0.0
    for j in range(9):
        along += axis[j] * free[j]
        done += axis[j] * dq[j]
    for j in range(9):
        dq[j] += free[j] * (wanted - done) / along


@kernel
def _linearize(
    chain: Any,
    q: Any,
    target: Any,
    trocar: Any,
    is_straight: bool,
    axis: Any,
    J: Any,
    L: Any,
    r: Any,
    free: Any,
) -> tuple[float, float]:
    """Fill r, J, L and free at q; returns what is missing [m], and how well the elbow can swing."""
    frames = np.empty((12, 3, 4))
    kin.forward(chain, q, frames)
    missing = constrained_ik.residual(frames, target, trocar, r)
    constrained_ik.constraints(frames, trocar, J)
    if is_straight:
        missing = max(missing, constrained_ik.hold_wrist(q, r, J))
    constrained_ik.factor(J, 0.0, L)
    constrained_ik.project(J, L, axis, free)
    alignment = 0.0
    for j in range(9):
        alignment += axis[j] * free[j]
    return missing, alignment


@kernel
def _correct(
    chain: Any,
    q: Any,
    target: Any,
    trocar: Any,
    is_straight: bool,
    axis: Any,
    level: float,
    tolerance: float,
    J: Any,
    L: Any,
    free: Any,
) -> float:
    """Move q (9,) onto the target, its part along axis to level; returns what is missing [m]."""
    r, dq = np.empty(8), np.empty(9)
    missing = np.inf
    for _ in range(MAX_ITERATIONS):
        missing, alignment = _linearize(chain, q, target, trocar, is_straight, axis, J, L, r, free)
        if alignment < MIN_ALIGNMENT or not missing < LOST:
            return max(missing, LOST)
        lag = level
        for j in range(9):
            lag -= axis[j] * q[j]
        if missing < tolerance and abs(lag) < SWING_TOLERANCE:
            return missing
        constrained_ik.min_norm_step(J, L, r, dq)
        _with_swing(dq, free, axis, lag)
        for j in range(9):
            q[j] += dq[j]
    return max(missing, LOST)


@kernel
def fill_knots(
    chain: Any,
    start: Any,
    motion: Any,
    trocar: Any,
    is_straight: bool,
    axis: Any,
    swing: float,
    length: float,
    tolerance: float,
    knots: Any,
    slopes: Any,
) -> tuple[float, int]:
    """Fill knots and slopes (n, 9), of which knots[0] holds the start.

    The tip moves from start (3, 4) by motion (2, 3): a shift [m], then a turn [rad], base frame;
    joints change by swing [rad] along axis (9,); all this takes the path length [m]. A straight
    tool that moves along its shaft is led by its pose alone, with `is_straight`.

    Returns:
        What was missing at the last knot tried [m], and its index: n - 1 where all went well.
    """
    J, L, free = np.zeros((8, 9)), np.zeros((8, 8)), np.empty(9)
    r, target, q = np.zeros(8), np.empty((3, 4)), knots[0].copy()
    last, missing, origin = len(knots) - 1, np.inf, 0.0
    for i in range(3):
        r[2 + i] = motion[0, i] / length
        r[5 + i] = motion[1, i] / length * constrained_ik.ROTATION_SCALE
    for j in range(9):
        origin += axis[j] * q[j]
    for k in range(last + 1):
        share = k / last
        pose_between(start, motion[0], motion[1], share, target)
        level = origin + share * swing
        missing = _correct(
            chain, q, target, trocar, is_straight, axis, level, tolerance, J, L, free
        )
        if not missing < tolerance:
            return missing, k
        constrained_ik.min_norm_step(J, L, r, slopes[k])
        _with_swing(slopes[k], free, axis, swing / length)
        for j in range(9):
            knots[k, j] = q[j]
            q[j] += slopes[k, j] * length / last
    return missing, last
