# SPDX-License-Identifier: BSD-3-Clause
"""The bias of joint torques, taken while the open jaws rest and hold nothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rst_control.config.torque_tension import TareConfig
from rst_control.kinematics.configuration import planning_joints
from rst_control.types import ARM_COUNT, Measurement, Vector, frozen_array

FADED = 4.0  # time constants of the filter after which it holds 2 % of what it held


@dataclass(frozen=True, eq=False)
class Tare:
    """A bias, and where it was taken."""

    bias: Vector  # (7,), [N m] that the motors give beyond gravity without any pull
    q: Vector  # (9,), [rad] planning configuration then
    stamp: float  # [s] clock of the measurements
    noise_share: float  # [-] variance of the bias over that of one reading


class TareTaker:
    """Averages while the jaws are open and the arm rests; keeps the last whole average.

    It begins when the filter has forgotten how the arm braked, or what the jaws held.

    Args:
        config: When that is, and how far from there it holds.
        filter_time: Time constant of the filter whose readings come [s].
    """

    def __init__(self, config: TareConfig, filter_time: float) -> None:
        self._config, self._settling = config, FADED * filter_time
        self.tare: Tare | None = None
        self._free_since: float | None = None  # [s] since when the open jaws rest
        self._since: float | None = None  # [s] of the average under way
        self._sum, self._count = np.zeros(ARM_COUNT), 0

    def forget_start(self) -> None:
        """Readings were missing: begin the average under way anew."""
        self._free_since = self._since = None

    def update(
        self, measured: Measurement, opening: float, excess: Vector, noise_share: float
    ) -> None:
        """Take in one reading.

        Args:
            measured: Newest.
            opening: Of the jaws [rad].
            excess: Filtered torques beyond the model [N m]. Shape (7,).
            noise_share: Variance of the filtered over that of one reading.
        """
        config, speed = self._config, np.abs(measured.velocity[:ARM_COUNT]).max()
        is_free = not measured.gripped and opening >= config.opening
        if not (is_free and speed <= config.at_rest_speed):
            self._free_since = self._since = None
            return
        if self._free_since is None:
            self._free_since = measured.stamp
        if measured.stamp - self._free_since < self._settling:
            return
        if self._since is None:
            self._since, self._sum, self._count = measured.stamp, np.zeros(ARM_COUNT), 0
        self._sum, self._count = self._sum + excess, self._count + 1
        if measured.stamp - self._since < config.time:
            return
        q, _ = planning_joints(measured.position)
        bias = frozen_array(self._sum / self._count, ARM_COUNT)
        # Filtered readings depend on each other; their mean is no noisier than one of them.
        self.tare = Tare(bias, frozen_array(q, len(q)), measured.stamp, noise_share)
        self._since = None

    def valid(self, now: float, q: Vector) -> Tare | None:
        """The bias, where it holds at a posture (9,) [rad] and a time [s]."""
        return None if self.why_none(now, q) else self.tare

    def why_none(self, now: float, q: Vector) -> str:
        """Why no bias holds at a posture (9,) [rad] and a time [s]; empty: one does."""
        if self.tare is None:
            return "no tare: the open jaws have not rested yet"
        away = np.abs(q[:ARM_COUNT] - self.tare.q[:ARM_COUNT])
        joint, most = int(away.argmax()), self._config.holds_within
        if not away[joint] <= most:
            return (
                f"no tare here: joint_{joint + 1} is {away[joint]:.2f} rad from where it was "
                f"taken, allowed {most:.2f}"
            )
        age, oldest = now - self.tare.stamp, self._config.holds_for
        if not age <= oldest:
            return f"tare {age:.0f} s old, allowed {oldest:.0f}"
        return ""
