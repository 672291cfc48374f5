# SPDX-License-Identifier: BSD-3-Clause
"""A robot without physics for tests: it goes where it is sent, and fails on demand."""

from __future__ import annotations

import math
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
    """A RobotBackend that reaches each set-point at once, or with a first-order lag.

    Args:
        position: Joints at the start [rad]. Shape (10,).
        clock: Present time [s].
        lag: Time constant of its answer [s]; 0: at once.
        tissue: What the jaws hold when they close; None: nothing.
    """

    def __init__(
        self,
        position: Vector,
        clock: Callable[[], float],
        lag: float = 0.0,
        tissue: LinearSpring | None = None,
    ) -> None:
        self._clock, self._lag, self.tissue = clock, lag, tissue
        self._position = np.array(position, dtype=float)
        self._velocity = np.zeros(JOINT_COUNT)
        self._goal = self._position.copy()
        self._updated = clock()
        self._frozen: Measurement | None = None
        self.setpoints: list[Setpoint] = []  # all that were sent, in order
        self.hold_count, self.clear_count = 0, 0
        self.fault, self.is_connected = "", True
        self.sent_to: Vector | None = None  # where it says that it holds
        self.clears_fault = True  # whether `clear_fault` has an effect

    def measured_js(self) -> Measurement:
        """Present joint states; the frozen ones while frozen."""
        if self._frozen is not None:
            return self._frozen
        self._update()
        return self._measurement()

    def servo_jp(self, setpoint: Setpoint) -> None:
        """Go to a set-point, unless a fault is latched."""
        self.setpoints.append(setpoint)
        if self.fault:
            return
        self._update()
        self._goal, self._velocity = setpoint.position.copy(), setpoint.velocity.copy()
        if self._lag == 0.0:
            self._position = self._goal.copy()

    def hold(self) -> None:
        """Stay where it is."""
        self._update()
        self.hold_count += 1
        self._goal, self._velocity = self._position.copy(), np.zeros(JOINT_COUNT)

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

    def _update(self) -> None:
        now = self._clock()
        if self._lag > 0.0:
            share = 1.0 - math.exp(-(now - self._updated) / self._lag)
            self._position = self._position + share * (self._goal - self._position)
        self._updated = now

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
