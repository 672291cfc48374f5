# SPDX-License-Identifier: BSD-3-Clause
"""Compiled damped least squares: nine joints under the trocar (2) and the tool pose (6).

The ninth freedom is the elbow's swing. Steps are damped least squares (Wampler 1986; Nakamura and
Hanafusa 1986); the swing descends a posture cost that pulls to a reference and away from the
joint limits, or is prescribed.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rst_control.kernels import kernel
from rst_control.kinematics import forward as kin
from rst_control.kinematics.rcm import rcm_jacobian, rcm_offset

Array = NDArray[np.float64]

ROTATION_SCALE = 0.1  # [m/rad], so that rows of J are alike: a radian of the tool counts as 0.1 m
ROWS = 8
LIMIT_POWER = 7  # of the pull away from a limit: weak in the middle, hard at the end
SWING_LIMIT = 0.3  # [rad] largest step of the swing
INSIDE = 1e-6  # [rad] of the limit to which joints outside are brought back
NEARLY = 1e-3  # [m] of what is missing, from where on the limits come before the posture
STALLED = 1e-9  # [rad] swing step below which the posture counts as settled


@kernel
def residual(frames: Any, target: Any, trocar: Any, r: Any) -> float:
    """Write what is missing to target (3, 4) and trocar into r (8,); returns its largest [m]."""
    turn = np.empty(3)
    x, y, _ = rcm_offset(frames, trocar)
    r[0], r[1] = -x, -y
    kin.turn_between(frames[kin.TIP], target, turn)
    worst = max(abs(x), abs(y))
    for i in range(3):
        r[2 + i] = target[i, 3] - frames[kin.TIP, i, 3]
        r[5 + i] = turn[i] * ROTATION_SCALE
        worst = max(worst, abs(r[2 + i]), abs(r[5 + i]))
    return worst


@kernel
def constraints(frames: Any, trocar: Any, J: Any) -> None:
    """Write the Jacobian of all constraints into J (8, 9)."""
    rcm_jacobian(frames, trocar, J[:2])
    kin.tip_jacobian(frames, ROTATION_SCALE, J[2:])


@kernel
def hold_wrist(q: Any, r: Any, J: Any) -> float:
    """Put a straight wrist in the place of the trocar in r (8,) and J (8, 9).

    With the wrist in the trocar the shaft's direction is free, so that there the tool is led by
    its pose alone. Returns what is missing to pitch and yaw zero [m].
    """
    for k in range(2):
        r[k] = -q[7 + k] * ROTATION_SCALE
        for j in range(9):
            J[k, j] = 0.0
        J[k, 7 + k] = ROTATION_SCALE
    return max(abs(r[0]), abs(r[1]))


@kernel
def factor(J: Any, damping: float, L: Any) -> None:
    """Write the Cholesky factor of J J^T + damping into L (8, 8)."""
    for i in range(ROWS):
        for j in range(i + 1):
            total = damping if i == j else 0.0
            for k in range(9):
                total += J[i, k] * J[j, k]
            for k in range(j):
                total -= L[i, k] * L[j, k]
            if i == j:
                L[i, i] = np.sqrt(max(total, 1e-18))
            else:
                L[i, j] = total / L[j, j]


@kernel
def min_norm_step(J: Any, L: Any, r: Any, dq: Any) -> None:
    """Write the smallest dq (9,) with J dq = r; L is the factor of J J^T."""
    y = np.empty(ROWS)
    for i in range(ROWS):
        total = r[i]
        for k in range(i):
            total -= L[i, k] * y[k]
        y[i] = total / L[i, i]
    for i in range(ROWS - 1, -1, -1):
        total = y[i]
        for k in range(i + 1, ROWS):
            total -= L[k, i] * y[k]
        y[i] = total / L[i, i]
    for j in range(9):
        total = 0.0
        for i in range(ROWS):
            total += J[i, j] * y[i]
        dq[j] = total


@kernel
def project(J: Any, L: Any, v: Any, out: Any) -> None:
    """Write the part of v (9,) that changes no constraint."""
    r = np.empty(ROWS)
    for i in range(ROWS):
        total = 0.0
        for j in range(9):
            total += J[i, j] * v[j]
        r[i] = total
    min_norm_step(J, L, r, out)
    for j in range(9):
        out[j] = v[j] - out[j]


@kernel
def posture_step(J: Any, L: Any, q: Any, posture: Any, out: Any) -> float:
    """Write the swing that improves the posture into out (9,); returns its length [rad].

    J and L are the constraints' Jacobian and factor; the rows of posture (4, 9) are reference,
    weight, lower and upper limit of q (9,).
    """
    slope, bend = np.empty(9), np.empty(9)
    for j in range(9):
        half = 0.5 * (posture[3, j] - posture[2, j])
        x = (q[j] - 0.5 * (posture[3, j] + posture[2, j])) / half
        steep = x ** (LIMIT_POWER - 1)
        slope[j] = -posture[1, j] * (q[j] - posture[0, j]) - steep * x / half
        bend[j] = posture[1, j] + LIMIT_POWER * steep / half**2
    return _swing(J, L, slope, bend, out)


@kernel
def limit_step(J: Any, L: Any, q: Any, posture: Any, out: Any) -> float:
    """Write the swing that brings joints back inside their limits into out (9,).

    Newton's step for the square of what they are outside, which is exact for one joint. Arguments
    and result are those of `posture_step`.
    """
    slope, bend = np.zeros(9), np.zeros(9)
    for j in range(9):
        slope[j] = max(0.0, posture[2, j] + INSIDE - q[j]) - max(0.0, q[j] - posture[3, j] + INSIDE)
        bend[j] = 1.0 if slope[j] != 0.0 else 0.0
    return _swing(J, L, slope, bend, out)


@kernel
def _swing(J: Any, L: Any, slope: Any, bend: Any, out: Any) -> float:
    """Write the way down `slope` (9,) that changes no constraint into out (9,); its length."""
    project(J, L, slope, out)
    square, curvature = 0.0, 0.0
    for j in range(9):
        square += out[j] * out[j]
        curvature += out[j] * out[j] * bend[j]
    if square < 1e-24:
        out[:] = 0.0
        return 0.0
    scale = square / curvature
    length = scale * np.sqrt(square)
    if length > SWING_LIMIT:
        scale *= SWING_LIMIT / length
    for j in range(9):
        out[j] *= scale
    return min(length, SWING_LIMIT)


@kernel
def _move(q: Any, dq: Any, max_step: float) -> None:
    largest = 0.0
    for j in range(9):
        largest = max(largest, abs(dq[j]))
    scale = min(1.0, max_step / largest) if largest > 0.0 else 1.0
    for j in range(9):
        q[j] += scale * dq[j]


@kernel
def is_inside(q: Any, posture: Any) -> bool:
    """Whether q (9,) keeps the limits of rows 2 and 3 of `posture`."""
    worst = -np.inf
    for j in range(9):
        worst = max(worst, posture[2, j] - q[j], q[j] - posture[3, j])
    return worst <= 0.0


@kernel
def solve(
    chain: Any, q: Any, target: Any, trocar: Any, posture: Any, rule: Any, is_settling: bool
) -> tuple[float, int]:
    """Move q (9,) in place to the target; returns what is missing [m] and the iterations taken.

    Stops at the tolerance with all joints inside their limits; `is_settling` asks for the best
    posture, too. `rule` holds tolerance [m], damping, largest step [rad] and most iterations.
    """
    frames, J, L = np.empty((12, 3, 4)), np.zeros((ROWS, 9)), np.zeros((ROWS, ROWS))
    r, dq, swing = np.empty(ROWS), np.empty(9), np.zeros(9)
    kin.forward(chain, q, frames)
    missing, swung, is_led = residual(frames, target, trocar, r), 1.0, False  # by the limits
    for iteration in range(int(rule[3])):
        if missing < rule[0] and (swung < STALLED if is_settling else is_inside(q, posture)):
            return missing, iteration
        constraints(frames, trocar, J)
        factor(J, rule[1] * missing * missing, L)
        min_norm_step(J, L, r, dq)
        is_led = is_led or (not is_settling and missing < NEARLY and not is_inside(q, posture))
        if is_led:
            swung = limit_step(J, L, q, posture, swing)
            if swung < STALLED and missing < rule[0]:  # no swing from here keeps the limits
                return missing, iteration
        else:
            swung = posture_step(J, L, q, posture, swing)
        for j in range(9):
            dq[j] += swing[j]
        _move(q, dq, rule[2])
        kin.forward(chain, q, frames)
        missing = residual(frames, target, trocar, r)
    return missing, int(rule[3])


@kernel
def search(
    chain: Any, seeds: Any, target: Any, trocar: Any, posture: Any, rule: Any, best: Any
) -> tuple[float, int, int]:
    """Try one start after the other until one ends inside the limits; write the best to best (9,).

    Returns:
        What is missing [m], starts and iterations taken.
    """
    q, least, iterations = np.empty(9), np.inf, 0
    for n in range(len(seeds)):
        q[:] = seeds[n]
        wrap(q, posture)
        missing, count = solve(chain, q, target, trocar, posture, rule, False)
        iterations += count
        wrap(q, posture)
        is_good = missing < rule[0] and is_inside(q, posture)
        if is_good or missing < least:
            least = missing
            best[:] = q
        if is_good:
            return missing, n + 1, iterations
    return least, len(seeds), iterations


@kernel
def wrap(q: Any, posture: Any) -> None:
    """Turn joints with a range of more than a turn by whole turns to near their reference.

    Of two turns the one inside the limits is taken.
    """
    for j in range(9):
        if posture[3, j] - posture[2, j] > 2.0 * np.pi:
            turns = np.round((q[j] - posture[0, j]) / (2.0 * np.pi))
            q[j] -= 2.0 * np.pi * turns
            if q[j] > posture[3, j]:
                q[j] -= 2.0 * np.pi
            elif q[j] < posture[2, j]:
                q[j] += 2.0 * np.pi
