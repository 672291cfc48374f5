# SPDX-License-Identifier: BSD-3-Clause
"""controller.yaml, `tool_play` and `joint_correction`: what is made up for of a real robot."""

from __future__ import annotations

from dataclasses import dataclass

from typed_config import number


@dataclass(frozen=True, kw_only=True)
class PlayCompensationConfig:
    """Play of pitch and yaw, and how fast it is taken up."""

    width: tuple[float, float] = number(0.0, 0.3, "rad")
    speed: float = number(0.01, 1.0, "rad/s")
    acceleration: float = number(0.1, 5.0, "rad/s^2")

    @property
    def is_on(self) -> bool:
        """Whether any play is made up for."""
        return any(self.width)


@dataclass(frozen=True, kw_only=True)
class JointCorrectionConfig:
    """By how much the arm is sent beyond set-points that its joints are measured off."""

    gain: float = number(0.0, 0.8, "")
    limit: float = number(0.0, 0.01, "rad")
    speed: float = number(0.001, 0.5, "rad/s")

    @property
    def is_on(self) -> bool:
        """Whether anything is corrected."""
        return self.gain > 0.0
