# SPDX-License-Identifier: BSD-3-Clause
"""Finds joint readings that have frozen: fresh stamps on old numbers."""

from __future__ import annotations

import numpy as np

from rst_control.types import JOINT_COUNT, JOINTS, Measurement, Vector


class FrozenJoints:
    """Finds joints whose reading stays the same to the last bit while they are sent elsewhere.

    At rest the reading of a coarse encoder may stay as it is for ever, and a joint sets off a while
    after its set-point. So it counts only once the set-point is away by more than a step of any
    encoder, and has been for a while.

    Args:
        way: That a set-point moves without its reading [rad].
        after: How long it has been that far [s].
    """

    def __init__(self, way: float, after: float) -> None:
        self._way, self._after = way, after
        self._sent = np.full(JOINT_COUNT, np.nan)  # [rad] set-point when the reading last changed
        self._since = np.full(JOINT_COUNT, np.inf)  # [s] when the set-point had gone far from there
        self._stuck: tuple[int, float] | None = None  # joint and reading [rad]
        self.objection = ""

    def look(self, last: Measurement, measured: Measurement, setpoint: Vector | None) -> None:
        """Take in a new measurement, and where the joints are sent [rad], shape (10,)."""
        position = measured.position
        if self._stuck is not None and position[self._stuck[0]] != self._stuck[1]:
            self._stuck, self.objection = None, ""
        if setpoint is None:
            self._restart()
            return
        anew = (position != last.position) | np.isnan(self._sent)
        self._sent = np.where(anew, setpoint, self._sent)
        away = np.abs(setpoint - self._sent)
        self._since = np.where(away > self._way, np.minimum(self._since, measured.stamp), np.inf)
        joint = int(self._since.argmin())
        if measured.stamp - self._since[joint] >= self._after and self._stuck is None:
            self._stuck = joint, float(position[joint])
            self.objection = (
                f"{JOINTS[joint]} frozen or blocked: it reads {position[joint]:.6f} rad without "
                f"any change while its set-point moved by {away[joint]:.4f}, "
                f"allowed {self._way:.4f}"
            )

    def forget(self) -> None:
        """Begin anew."""
        self._restart()
        self._stuck, self.objection = None, ""

    def _restart(self) -> None:
        self._sent[:], self._since[:] = np.nan, np.inf
