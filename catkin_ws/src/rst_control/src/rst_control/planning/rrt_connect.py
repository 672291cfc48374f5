# SPDX-License-Identifier: BSD-3-Clause
"""Compiled search for a way of straight joint-space edges between two configurations.

RRT-Connect (J. J. Kuffner and S. M. LaValle, ICRA 2000): two trees grow towards random samples and
each other. Every edge is checked everywhere, not only at samples: no body can move further than
the joints carry it, so a place with some room vouches for all that is nearer than that room.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from rst_control.kernels import kernel
from rst_control.planning.collision_kernels import min_room

RESOLUTION = 1e-3  # [m] of motion that is stepped over at least; half of it may go unseen


@kernel
def carried(a: Any, b: Any, reach: Any) -> float:
    """Most that any part of the robot may move from a to b (9,) [m]."""
    total = 0.0
    for j in range(9):
        total += reach[j] * abs(b[j] - a[j])
    return total


@kernel
def free_share(chain: Any, shapes: Any, a: Any, b: Any) -> float:
    """Share of the straight way from a to b (9,) that is free; 1.0: all of it."""
    motion, joints = carried(a, b, shapes.reach), np.empty(9)
    share, known = 0.0, 0.0
    while True:
        for j in range(9):
            joints[j] = a[j] + share * (b[j] - a[j])
        room, _ = min_room(chain, joints, shapes)
        if not room >= 0.0:
            return known
        if share >= 1.0:
            return 1.0
        known = share
        share = 1.0 if motion <= room else min(1.0, share + max(room, RESOLUTION) / motion)


@kernel
def _nearest(nodes: Any, count: int, q: Any, reach: Any) -> int:
    best, least = 0, np.inf
    for n in range(count):
        total = 0.0
        for j in range(9):
            total += (reach[j] * (nodes[n, j] - q[j])) ** 2
        if total < least:
            best, least = n, total
    return best


@kernel
def _grow(
    chain: Any, shapes: Any, nodes: Any, parents: Any, count: int, goal: Any, step: float
) -> tuple[int, bool]:
    """Add a node towards the goal (9,), by a step [m] at most.

    Returns:
        Its index, -1 where the way is blocked, and whether it is at the goal.
    """
    near = _nearest(nodes, count, goal, shapes.reach)
    target, motion = goal.copy(), carried(nodes[near], goal, shapes.reach)
    arrives = motion <= step
    if not arrives:
        for j in range(9):
            target[j] = nodes[near, j] + step / motion * (goal[j] - nodes[near, j])
    if free_share(chain, shapes, nodes[near], target) < 1.0:
        return -1, False
    nodes[count] = target
    parents[count] = near
    return count, arrives


@kernel
def connect(
    chain: Any,
    shapes: Any,
    ends: Any,
    samples: Any,
    step: float,
    nodes: Any,
    parents: Any,
) -> tuple[int, int]:
    """Grow trees from both ends (2, 9) towards the samples (n, 9) until they meet.

    Fills nodes (2, m, 9) and parents (2, m), in which each tree's root is node 0, its own parent.

    Returns:
        Index of the node at which they meet, in the first tree and in the second; -1: nowhere.
    """
    counts, most = np.ones(2, dtype=np.int64), nodes.shape[1]
    for tree in range(2):
        nodes[tree, 0], parents[tree, 0] = ends[tree], 0
    for n in range(len(samples)):
        own = n % 2
        other = 1 - own
        if counts[own] >= most:
            return -1, -1
        new, _ = _grow(chain, shapes, nodes[own], parents[own], counts[own], samples[n], step)
        if new < 0:
            continue
        counts[own] += 1
        while counts[other] < most:
            met, arrives = _grow(
                chain, shapes, nodes[other], parents[other], counts[other], nodes[own, new], step
            )
            if met < 0:
                break
            counts[other] += 1
            if arrives:
                return (new, met) if own == 0 else (met, new)
    return -1, -1


@kernel
def _place(way: Any, along: Any, s: float, q: Any) -> int:
    """Write the place s [m] along the way into q (9,); returns the edge that it is on."""
    edge = 0
    while edge < len(along) - 2 and along[edge + 1] < s:
        edge += 1
    length = along[edge + 1] - along[edge]
    share = min(1.0, (s - along[edge]) / length) if length > 0.0 else 0.0
    for j in range(9):
        q[j] = way[edge, j] + share * (way[edge + 1, j] - way[edge, j])
    return edge


@kernel
def shortcut(chain: Any, shapes: Any, way: Any, shares: Any) -> int:
    """Put straight edges in the place of bends of the way (n, 9) where they are free, in place.

    Each row of shares (m, 2) picks two places by their share of the way, in order. What would add
    a corner is left, since the robot stops at each.

    Returns:
        How many points are left; the rest of `way` means nothing.
    """
    count, q = len(way), np.empty((2, 9))
    along = np.zeros(len(way))
    for m in range(len(shares)):
        for n in range(1, count):
            along[n] = along[n - 1] + carried(way[n - 1], way[n], shapes.reach)
        whole = along[count - 1]
        first = _place(way, along[:count], shares[m, 0] * whole, q[0])
        last = _place(way, along[:count], shares[m, 1] * whole, q[1])
        if last < first + 2 or free_share(chain, shapes, q[0], q[1]) < 1.0:
            continue
        rest = way[last + 1 : count].copy()
        way[first + 1], way[first + 2] = q[0], q[1]
        count = first + 3 + len(rest)
        way[first + 3 : count] = rest
    return count
