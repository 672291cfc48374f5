# SPDX-License-Identifier: BSD-3-Clause
"""Compiled distances between capsules, and between capsules and planes, along a sampled path.

A capsule is all that is nearer than its radius to a line between two points, so the distance of two
capsules is that of their lines less both radii.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rst_control.kernels import kernel
from rst_control.kinematics import forward as kin

BASE = -1  # frame of bodies that do not move
RESOLUTION = 5e-4  # [m] of motion that is stepped over at least; half of it may go unseen


class Shapes(NamedTuple):
    """What must keep apart."""

    capsules: NDArray[np.float64]  # (n, 7): start and end in the frame, radius [m]
    frames: NDArray[np.int64]  # (n,): row of `forward.forward`'s frames, or BASE
    pairs: NDArray[np.int64]  # (m, 2): capsules that must keep apart
    plane_pairs: NDArray[np.int64]  # (k, 2): capsule, and plane that it must keep above
    planes: NDArray[np.float64]  # (p, 5): unit normal, offset along it, distance to keep [m]
    allowed: float  # [m] between the capsules of a pair
    reach: NDArray[np.float64]  # (9,): furthest that a capsule's line may be from each joint [m]


@kernel
def place(frames: Any, shapes: Any, ends: Any) -> None:
    """Write start and end of every capsule, base frame, [m], into ends (n, 6)."""
    for n in range(len(shapes.capsules)):
        body, k = shapes.capsules[n], shapes.frames[n]
        if k == BASE:
            for i in range(6):
                ends[n, i] = body[i]
            continue
        for i in range(3):
            x, y, z = frames[k, i, 0], frames[k, i, 1], frames[k, i, 2]
            ends[n, i] = frames[k, i, 3] + x * body[0] + y * body[1] + z * body[2]
            ends[n, 3 + i] = frames[k, i, 3] + x * body[3] + y * body[4] + z * body[5]


@kernel
def _dot(ax: float, ay: float, az: float, bx: float, by: float, bz: float) -> float:
    return ax * bx + ay * by + az * bz


@kernel
def segment_distance(a: Any, b: Any) -> float:
    """Distance [m] of two line segments (6,), start and end each; exact to a millionth of them.

    Source: C. Ericson, Real-Time Collision Detection, 2005, section 5.1.9.
    """
    ux, uy, uz = a[3] - a[0], a[4] - a[1], a[5] - a[2]
    vx, vy, vz = b[3] - b[0], b[4] - b[1], b[5] - b[2]
    wx, wy, wz = a[0] - b[0], a[1] - b[1], a[2] - b[2]
    uu, vv = _dot(ux, uy, uz, ux, uy, uz), _dot(vx, vy, vz, vx, vy, vz)
    uv = _dot(ux, uy, uz, vx, vy, vz)
    uw, vw = _dot(ux, uy, uz, wx, wy, wz), _dot(vx, vy, vz, wx, wy, wz)
    square = uu * vv - uv * uv
    s = 0.0
    if square > 1e-12 * uu * vv:  # else parallel: any s will do
        s = min(max((uv * vw - uw * vv) / square, 0.0), 1.0)
    t = (uv * s + vw) / vv if vv > 0.0 else 0.0
    if t < 0.0 or t > 1.0 or vv == 0.0:
        t = min(max(t, 0.0), 1.0)
        s = min(max((uv * t - uw) / uu, 0.0), 1.0) if uu > 0.0 else 0.0
    dx, dy, dz = wx + s * ux - t * vx, wy + s * uy - t * vy, wz + s * uz - t * vz
    return float(np.sqrt(dx * dx + dy * dy + dz * dz))


@kernel
def _height(plane: Any, end: Any) -> float:
    start = _dot(plane[0], plane[1], plane[2], end[0], end[1], end[2])
    return min(start, _dot(plane[0], plane[1], plane[2], end[3], end[4], end[5])) - plane[3]


@kernel
def _smallest_room(ends: Any, shapes: Any) -> tuple[float, int]:
    """Least room over what is allowed [m], and the index of its pair.

    Pairs of capsules are counted first, then those with planes. A room of NaN counts as least.
    """
    least, which, count = np.inf, -1, len(shapes.pairs)
    for n in range(count):
        a, b = shapes.pairs[n, 0], shapes.pairs[n, 1]
        distance = segment_distance(ends[a], ends[b])
        room = distance - shapes.capsules[a, 6] - shapes.capsules[b, 6] - shapes.allowed
        if not room >= least:
            least, which = room, n
            if np.isnan(room):
                return least, which
    for n in range(len(shapes.plane_pairs)):
        a, plane = shapes.plane_pairs[n, 0], shapes.planes[shapes.plane_pairs[n, 1]]
        room = _height(plane, ends[a]) - shapes.capsules[a, 6] - plane[4]
        if not room >= least:
            least, which = room, count + n
            if np.isnan(room):
                return least, which
    return least, which


@kernel
def min_room(chain: Any, q: Any, shapes: Any) -> tuple[float, int]:
    """Least room over what is allowed [m] at q (9,), and the index of its pair."""
    frames, ends = np.empty((12, 3, 4)), np.empty((len(shapes.capsules), 6))
    kin.forward(chain, q, frames)
    place(frames, shapes, ends)
    return _smallest_room(ends, shapes)


@kernel
def motion_bound(q: Any, k: int, spacing: float, reach: Any) -> float:
    """How far two capsules may move to each other from sample k of q (n, 3, 9) to the next [m].

    Between samples each joint is a cubic of s: its speed is at most the larger of those at the
    ends and half a step of the larger bend there.
    """
    total = 0.0
    for j in range(9):
        speed = max(abs(q[k, 1, j]), abs(q[k + 1, 1, j]))
        bend = max(abs(q[k, 2, j]), abs(q[k + 1, 2, j]))
        total += reach[j] * (speed + 0.5 * spacing * bend)
    return total * spacing


@kernel
def _worst(chain: Any, q: Any, shapes: Any) -> tuple[float, int]:
    least, which = np.inf, -1
    for k in range(len(q)):
        room, index = min_room(chain, q[k, 0], shapes)
        if room < least:
            least, which = room, index
    return least, which


@kernel
def sweep(chain: Any, q: Any, spacing: float, shapes: Any) -> tuple[float, int]:
    """Follow samples q (n, 3, 9) of a path and all between them, in steps that the room permits.

    Conservative advancement (B. V. Mirtich, PhD thesis, Berkeley 1996, section 2.3.2): where there
    is room, nothing can happen before the bodies have moved by so much. So no step leads over a
    place with less room than allowed by more than half of RESOLUTION.

    Returns:
        Where the room [m] is negative or NaN anywhere: the least at any checked place, and the
        index of its pair. Else the room at the end, which is not the path's least.
    """
    joints = np.empty(9)
    k, share, last = 0, 0.0, len(q) - 1
    while True:
        ahead = min(k + 1, last)
        for j in range(9):
            joints[j] = q[k, 0, j] + share * (q[ahead, 0, j] - q[k, 0, j])
        room, which = min_room(chain, joints, shapes)
        if not room >= 0.0:
            worst, index = _worst(chain, q, shapes)
            return (worst, index) if worst < room else (room, which)
        if k == last:
            return room, which
        step = max(room, RESOLUTION)
        while k < last:
            motion = motion_bound(q, k, spacing, shapes.reach)
            if not (1.0 - share) * motion <= step:
                share += step / motion
                break
            step -= (1.0 - share) * motion
            k, share = k + 1, 0.0
