# SPDX-License-Identifier: BSD-3-Clause
"""From a click into the endoscope's picture to a point of the tissue."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ASIDE = 0.006  # [m] from the click to a node of the sheet, at most
FLAT = 0.05  # cosine of the ray to the sheet's normal, from which the hit is sharp enough
KEPT = 10.0  # [s] for which it is known how the camera was

T = TypeVar("T")


class NotOnTissueError(ValueError):
    """A click means no point of the tissue; says why."""


class StampedHistory(Generic[T]):
    """What was said of the camera, by the time from which it holds.

    Args:
        clock: Steady clock [s].
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._said: deque[tuple[float, float, T]] = deque()  # when it came, its stamp, what

    def add(self, stamp: float, value: T) -> None:
        """Take what holds from a stamp on [s]; with 0, for all pictures."""
        now = self._clock()
        self._said.append((now, stamp, value))
        while len(self._said) > 1 and self._said[1][0] < now - KEPT:
            self._said.popleft()

    def at(self, stamp: float) -> T:
        """What held when a picture of that stamp was taken.

        Raises:
            NotOnTissueError: Nothing was ever said, or nothing of that time is kept.
        """
        said = tuple(self._said)  # others come meanwhile
        if not said:
            raise NotOnTissueError("nobody says where the endoscope is")
        for _, since, value in reversed(said):
            if since <= stamp:
                return value
        if stamp == 0.0:
            raise NotOnTissueError("that picture has no time stamp, but the endoscope moves")
        raise NotOnTissueError(
            "where the endoscope was when that picture was taken is no longer known: "
            "click into a newer picture"
        )


@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole camera, in pixels of the whole picture.

    Attributes:
        matrix: Intrinsic. Shape (3, 3).
        pose: Of the optical frame in the base frame: x right, y down, z forward. Shape (4, 4).
        size: Width and height of the picture [pixels].
        region: Left, top, right and bottom of what this camera sees [pixels].
    """

    matrix: Array
    pose: Array
    size: tuple[int, int]
    region: tuple[int, int, int, int]

    def ray(self, x: float, y: float) -> tuple[Array, Array]:
        """Where the ray of a pixel begins [m], and its unit direction; base frame.

        Args:
            x: From the left edge of the whole picture, as a share of its width.
            y: From its top, as a share of its height.

        Raises:
            NotOnTissueError: This camera does not see there.
        """
        u, v = x * self.size[0], y * self.size[1]
        left, top, right, bottom = self.region
        if not (left <= u < right and top <= v < bottom):
            raise NotOnTissueError("that is outside the endoscope's picture")
        way = self.pose[:3, :3] @ np.linalg.solve(self.matrix, [u, v, 1.0])
        return self.pose[:3, 3], way / np.linalg.norm(way)


@dataclass(frozen=True, eq=False)
class Sheet:
    """The tissue at rest.

    Attributes:
        nodes: Base frame [m]. Shape (n, 3).
        normal: Unit vector. Shape (3,).
    """

    nodes: Array
    normal: Array

    def nearest(self, camera: Camera, x: float, y: float) -> Array:
        """The node that is nearest to where the ray of a click meets the sheet [m]. Shape (3,).

        Args:
            camera: That took the picture.
            x: Share of the picture's width.
            y: Share of its height.

        Raises:
            NotOnTissueError: The ray passes the sheet.
        """
        origin, way = camera.ray(x, y)
        slope = float(way @ self.normal)
        if abs(slope) < FLAT:
            angle, least = np.degrees(np.arcsin([abs(slope), FLAT]))
            words = f"at {angle:.1f}°, allowed: from {least:.1f}° on"
            raise NotOnTissueError(f"the endoscope sees the tissue from its edge there, {words}")
        depth = float((self.nodes[0] - origin) @ self.normal) / slope
        aside = np.linalg.norm(self.nodes - (origin + depth * way), axis=1)
        if depth <= 0.0:
            raise NotOnTissueError("there is no tissue: it lies behind the endoscope")
        if aside.min() > ASIDE:
            words = f"the nearest is {1e3 * aside.min():.1f} mm away, allowed: {1e3 * ASIDE:g} mm"
            raise NotOnTissueError(f"there is no tissue: {words}")
        found: Array = self.nodes[int(aside.argmin())]
        return found
