# SPDX-License-Identifier: BSD-3-Clause
"""Pulls where no tension can be relied on: by distance, as if the tissue were the stiffest."""

from __future__ import annotations

from rst_control.config import TensionConfig
from rst_control.types import Measurement


class BlindPulls:
    """Turns tensions into distances from the grasp.

    Tissue that is no stiffer than `blind_stiffness` is pulled no harder than was asked for, and
    slack tissue less. Stiffer tissue is pulled harder, and nothing measures it: so the distances
    are only as safe as that number is true.

    Args:
        config: Source, stiffest tissue and largest tension.
    """

    def __init__(self, config: TensionConfig) -> None:
        self._config = config

    @property
    def most(self) -> float:
        """Furthest that tissue may be pulled from the grasp [m]."""
        return self.way(self._config.maximum)

    def way(self, tension: float) -> float:
        """Distance [m] that gives a tension [N] on the stiffest tissue."""
        return tension / self._config.blind_stiffness

    def why(self, measured: Measurement) -> str:
        """Why the tension cannot be relied on, with tissue to be grasped or held; empty: it can.

        Torques tell a tension only from the grasp on, where their bias is taken. So before it
        they count as trusted, and the pull looks again when it begins.
        """
        if self._config.source == "none":
            return "tension.source is none"
        if self._config.source == "joint_torque" and not measured.gripped:
            return ""
        return measured.tension_invalid_reason

    def words(self, why: str) -> str:
        """What a blind pull says beside its distance."""
        stiffest = self._config.blind_stiffness
        return f" by distance, for tissue up to {stiffest:.0f} N/m (no trusted tension: {why})"
