# SPDX-License-Identifier: BSD-3-Clause
"""How OpenRST finds its zeros: each joint is driven against both its stops and then to the middle.

The jaws and the wrist move over their whole range, so this is for outside of a patient.
"""

from __future__ import annotations

import numpy as np

from rst_control.kinova.stand_in.config import OpenRstConfig
from rst_control.types import Vector

PITCH, LEFT, RIGHT = range(3)
# Joint, end of its range in our model's signs, whether the node waits there. The order is the
# node's; the jaw that is not driven is where it does not meet the other.
SWEEP = (
    (PITCH, 1.0, True),
    (PITCH, -1.0, True),
    (PITCH, 0.0, False),
    (LEFT, 1.0, True),
    (RIGHT, 1.0, True),
    (LEFT, -1.0, True),
    (LEFT, 1.0, False),
    (RIGHT, -1.0, True),
    (RIGHT, 0.0, False),
    (LEFT, 0.0, False),
)


class Homing:
    """One homing, from wherever the joints are.

    Args:
        config: Speed, stops and waits.
    """

    def __init__(self, config: OpenRstConfig) -> None:
        self._config = config
        self._stage, self._waited = 0, 0.0

    @property
    def is_done(self) -> bool:
        """The joints are at their zeros."""
        return self._stage == len(SWEEP)

    def step(self, position: Vector, time: float) -> Vector:
        """Joints [rad] after a further time [s]; shape (3,)."""
        config = self._config
        joint, end, waits = SWEEP[self._stage]
        target = config.signs[joint] * end * config.stops[joint]
        moved = np.array(position)
        most = config.homing_speed * time
        moved[joint] += np.clip(target - position[joint], -most, most)
        if abs(moved[joint] - target) > 1e-9:
            return moved
        self._waited += time
        if not waits or self._waited >= config.homing_dwell:
            self._stage, self._waited = self._stage + 1, 0.0
        return moved
