# SPDX-License-Identifier: BSD-3-Clause
"""A trocar in a body wall that breathes, and gives way to the shaft like a spring."""

from __future__ import annotations

from typing import Final

import numpy as np

from rst_control.config.plant import BodyWallConfig
from rst_control.types import Vector, unit_vector

FAR: Final = 0.05  # [m] beside the trocar; no breath is so deep, so the shaft is not in it


class BodyWall:
    """Where the trocar is, and with what force it pushes the shaft.

    Args:
        config: Breath, stiffness and slack.
        trocar: Where it is between two breaths, base frame, [m]. Shape (3,).
    """

    def __init__(self, config: BodyWallConfig, trocar: Vector) -> None:
        self._config, self._way = config, unit_vector(config.way)
        self._home = np.array(trocar)

    def trocar(self, time: float) -> Vector:
        """Its place after a time [s] from a breath's end: stroke / 2 (1 - cos(2 pi f t)) away."""
        breath = 1.0 - np.cos(2.0 * np.pi * self._config.rate * time)
        place: Vector = self._home + 0.5 * self._config.stroke * breath * self._way
        return place

    def force(self, time: float, base: Vector, end: Vector) -> tuple[Vector, Vector]:
        """Force on the shaft [N], and the point of the shaft at which it pushes [m]; shapes (3,).

        It is stiffness times the shaft's distance from the trocar, less the slack, towards it.
        There is none where the shaft ends before the trocar, or is far beside it.

        Args:
            time: [s].
            base: One end of the shaft, base frame, [m]. Shape (3,).
            end: The other. Shape (3,).
        """
        trocar, way = self.trocar(time), unit_vector(end - base)
        along = float((trocar - base) @ way)
        point = base + along * way
        aside = trocar - point
        distance = float(np.linalg.norm(aside))
        pressed = distance - self._config.slack
        passes = 0.0 <= along <= float((end - base) @ way) and distance <= FAR
        if pressed <= 0.0 or not passes:
            return np.zeros(3), point
        push: Vector = (self._config.stiffness * pressed / distance) * aside
        return push, point
