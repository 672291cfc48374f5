# SPDX-License-Identifier: BSD-3-Clause
"""The way that the tip of the tool took last."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

SPACING = 0.001  # [m] between two points
LONGEST = 250  # points that are kept


class Trail:
    """Collects the way; cheap enough for every step of the simulation."""

    def __init__(self) -> None:
        self._points: deque[tuple[float, float, float]] = deque(maxlen=LONGEST)

    def add(self, tip: NDArray[np.float64]) -> None:
        """Note where the tip is, base frame, [m]. Shape (3,)."""
        x, y, z = tip.tolist()
        if self._points:
            a, b, c = self._points[-1]
            if (x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2 < SPACING**2:
                return
        self._points.append((x, y, z))

    @property
    def points(self) -> NDArray[np.float64]:
        """The way so far, oldest first, base frame, [m]. Shape (n, 3), a copy."""
        return np.array(self._points, dtype=float).reshape(-1, 3)
