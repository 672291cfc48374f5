# SPDX-License-Identifier: BSD-3-Clause
"""Compiled arithmetic on the joints for what the simulated robot does at every step."""

from __future__ import annotations

from typing import Any

import numpy as np

from rst_control.kernels import kernel


@kernel
def hermite(p: Any, v: Any, start: float, p_end: Any, v_end: Any, end: float, time: float) -> Any:
    """Cubic between two set-points, with their positions and velocities at its ends.

    Returns:
        Position [rad] and velocity [rad/s] at a time [s]. Shape (2, n).
    """
    span = end - start
    u = (time - start) / span
    course = np.empty((2, p.size))
    for j in range(p.size):
        step, a, b = p_end[j] - p[j], v[j] * span, v_end[j] * span
        square, cube = 3.0 * step - 2.0 * a - b, a + b - 2.0 * step
        course[0, j] = p[j] + u * (a + u * (square + u * cube))
        course[1, j] = (a + u * (2.0 * square + 3.0 * u * cube)) / span
    return course


@kernel
def clamped(position: Any, lower: Any, upper: Any) -> Any:
    """Position within limits, a new array. Shape (n,)."""
    within = np.empty(position.size)
    for j in range(position.size):
        within[j] = min(max(position[j], lower[j]), upper[j])
    return within


@kernel
def outside(position: Any, lower: Any, upper: Any) -> int:
    """First joint beyond its limits; -1: none."""
    for j in range(position.size):
        if position[j] < lower[j] or position[j] > upper[j]:
            return j
    return -1


@kernel
def furthest(position: Any, other: Any) -> tuple[int, float]:
    """Joint that is furthest away, and how far [rad]; not a number is infinitely far."""
    joint, most = 0, -1.0
    for j in range(position.size):
        away = abs(position[j] - other[j])
        if np.isnan(away):
            return j, np.inf
        if away > most:
            joint, most = j, away
    return joint, most


@kernel
def fastest(
    position: Any, velocity: Any, last: Any, span: float, allowed: Any
) -> tuple[int, float]:
    """Joint closest to or furthest above its speed limit, and its speed [rad/s].

    A speed is the larger of what a set-point says and what it takes to come from the `last` one
    within the time `span` [s].
    """
    joint, worst, speed = 0, -np.inf, 0.0
    for j in range(position.size):
        of_joint = max(abs(velocity[j]), abs(position[j] - last[j]) / span)
        if of_joint - allowed[j] > worst:
            joint, worst, speed = j, of_joint - allowed[j], of_joint
    return joint, speed
