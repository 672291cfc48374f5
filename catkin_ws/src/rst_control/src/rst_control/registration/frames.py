# SPDX-License-Identifier: BSD-3-Clause
"""Frames as tf joins them: where one is in another, as far as that is known and recent."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rst_control.kinematics.rotations import rotation_of
from rst_control.registration.tracked_place import untimely
from rst_control.types import BASE, Cause, Reason

Array = NDArray[np.float64]
MAX_DEPTH: Final = 100  # frames from one to the root; more are taken for a circle


@dataclass(frozen=True, eq=False)
class Link:
    """How a frame hangs on its parent."""

    parent: str
    T: Array  # (4, 4), pose of the frame in its parent, [m]
    stamp: float  # [s] steady clock; infinite: it never moves


def pose(place: tuple[float, float, float], turn: tuple[float, float, float, float]) -> Array:
    """Homogeneous matrix (4, 4) of a place [m] and a quaternion x, y, z, w of any length.

    Raises:
        ValueError: A number is not finite, or the quaternion is zero.
    """
    if not np.isfinite([*place, *turn]).all():
        raise ValueError("a number that is not finite")
    T = np.eye(4)
    T[:3, :3] = rotation_of(turn)
    T[:3, 3] = place
    return T


class Frames:
    """The tree of all frames heard of."""

    def __init__(self) -> None:
        self._links: dict[str, Link] = {}

    def put(self, frame: str, link: Link) -> None:
        """Note how a frame hangs on its parent; the newest counts."""
        self._links[_plain(frame)] = link

    def in_base(self, frame: str, now: float, age: float) -> Array | Cause:
        """Pose of a frame in base_link, shape (4, 4), or why it is not known.

        Args:
            frame: Its name; empty: base_link.
            now: Time [s], steady clock.
            age: Of a link that moves, at most [s].
        """
        name = _plain(frame) or BASE
        if name == BASE:
            return np.eye(4)
        chain, base = self._to_root(name, now, age), self._to_root(BASE, now, age)
        if isinstance(chain, Cause):
            return chain
        if isinstance(base, Cause):
            return base
        (root, T), (base_root, T_base) = chain, base
        if root != base_root:
            words = f"frame {name!r} hangs on {root!r}, {BASE} on {base_root!r}: tf does not join"
            return Cause(Reason.UNKNOWN_FRAME, f"{words} them")
        return np.array(np.linalg.solve(T_base, T), dtype=np.float64)

    def _to_root(self, frame: str, now: float, age: float) -> tuple[str, Array] | Cause:
        """The root of a frame, and the frame's pose in it."""
        T: Array = np.eye(4)
        at = frame
        for _ in range(MAX_DEPTH):
            link = self._links.get(at)
            if link is None:
                return at, T
            is_moving = link.stamp != math.inf
            # tf's static_transform_publisher stamps its transforms by its period ahead
            if is_moving and (cause := untimely(f"frame {at!r}", link.stamp, now, age, ahead=age)):
                return cause
            T, at = np.array(link.T @ T), link.parent
        return Cause(Reason.UNKNOWN_FRAME, f"frame {frame!r} hangs in a circle of frames")


def _plain(frame: str) -> str:
    """A name without the slash that tf of ROS 1 once had in front."""
    return frame.removeprefix("/")
