# SPDX-License-Identifier: BSD-3-Clause
"""A robot without physics for tests: it goes where it is sent, and fails on demand."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from rst_control.kinematics.configuration import planning_joints
from rst_control.types import JOINT_COUNT, Measurement, Setpoint

Vector = NDArray[np.float64]


class LinearSpring:
    """Tissue as a spring from the point where jaws that were open closed.

    Args:
        tip_of: Tool tip from joint positions, base frame, [m].
        stiffness: [N/m].
        closed_opening: Jaws closed below this hold it [rad].
    """

    def __init__(
        self, tip_of: Callable[[Vector], Vector], stiffness: float, closed_opening: float = 0.02
    ) -> None:
        self._tip_of, self._closed = tip_of, closed_opening
        self.stiffness = stiffness
        self._anchor: Vector | None = None
        self._were_open = False

    @property
    def is_held(self) -> bool:
        """Whether the jaws hold it."""
        return self._anchor is not None

    def force(self, position: Vector) -> Vector:
        """Force on the jaws at joint positions, base frame, [N]. Shape (3,)."""
        if planning_joints(position)[1] > self._closed:
            self._anchor, self._were_open = None, True
        elif self._were_open:
            self._anchor, self._were_open = self._tip_of(position).copy(), False
        if self._anchor is None:
            return np.zeros(3)
        return self.stiffness * (self._anchor - self._tip_of(position))


class FakeRobot:
    """A RobotBackend that reaches each set-point at once.

    Args:
        position: Joints at the start [rad]. Shape (10,).
        clock: Present time [s].
        tissue: What the jaws hold when they close; None: nothing.
    """

    def __init__(
        self,
        position: Vector,
        clock: Callable[[], float],
        tissue: LinearSpring | None = None,
    ) -> None:
        self._clock, self.tissue = clock, tissue
        self._position = np.array(position, dtype=float)
        self._velocity = np.zeros(JOINT_COUNT)
        self._frozen: Measurement | None = None
        self.clear_count = 0
        self.fault, self.is_connected = "", True
        self.sent_to: Vector | None = None  # where it says that it holds
        self.clears_fault = True  # whether `clear_fault` has an effect

    def measured_js(self) -> Measurement:
        """Present joint states; the frozen ones while frozen."""
        return self._measurement() if self._frozen is None else self._frozen

    def servo_jp(self, setpoint: Setpoint) -> None:
        """Go to a set-point, unless a fault is latched."""
        if not self.fault:
            self._position, self._velocity = setpoint.position.copy(), setpoint.velocity.copy()

    def hold(self) -> None:
        """Stay where it is."""
        self._velocity = np.zeros(JOINT_COUNT)

    def clear_fault(self) -> None:
        """Take set-points again, if `clears_fault` says so."""
        self.clear_count += 1
        if self.clears_fault:
            self.fault = ""

    def freeze(self) -> None:
        """Let joint states grow stale: from now on they stay as they are, stamp included."""
        self._frozen = self.measured_js()

    def thaw(self) -> None:
        """Publish fresh joint states again."""
        self._frozen = None

    def push(self, offset: Vector) -> None:
        """Move the joints off their course [rad]. Shape (10,)."""
        self._position = self._position + offset

    def _measurement(self) -> Measurement:
        force = np.zeros(3) if self.tissue is None else self.tissue.force(self._position)
        return Measurement(
            position=self._position,
            velocity=self._velocity,
            effort=np.zeros(JOINT_COUNT),
            stamp=self._clock(),
            force=force,
            gripped=self.tissue is not None and self.tissue.is_held,
            connected=self.is_connected,
            fault=self.fault,
            sent_to=self.sent_to,
        )
