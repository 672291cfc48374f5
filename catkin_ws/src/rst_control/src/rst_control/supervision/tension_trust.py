# SPDX-License-Identifier: BSD-3-Clause
"""Whether the tension is relied on, and how far the tissue is pulled, from a grasp to its release.

A tension that was once found wrong stays invalid until the jaws have opened: a sensor that
recovers may fail again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import exp, inf
from typing import Final

import numpy as np

from rst_control.config import EMPTY, MotionConfig, TensionConfig
from rst_control.config.sensors import SensorConfig
from rst_control.kinematics.configuration import planning_joints
from rst_control.tension.grasp_response import GraspResponse
from rst_control.types import Measurement, Vector

AVERAGE: Final = 0.05  # [s] over which the tension of empty jaws is averaged


def about_gain(config: MotionConfig) -> str:
    """What a tension that reads too little could do at this site, or how it is bounded.

    Such a tension looks like softer tissue. Only the way of the pull bounds it. Empty where pulls
    are by distance, or the pull path itself is short enough.
    """
    tension, length = config.controller.tension, config.scene.max_displacement
    stiffest, bound = tension.blind_stiffness, tension.limit / tension.blind_stiffness
    if tension.source == "none" or length <= bound:
        return ""
    if tension.gain == "unchecked":
        return (
            f"no pull goes further than {bound * 1e3:.1f} mm: tension.gain is unchecked; once "
            "known weights read right at this site, set it to checked"
        )
    return (
        f"a tension that reads too little would let tissue of {stiffest:.0f} N/m come to "
        f"{stiffest * length:.1f} N, limit {tension.limit:.1f} N; tension.gain: unchecked, or "
        f"scene.max_displacement up to {bound * 1e3:.1f} mm, bounds it"
    )


class TensionTrust:
    """Follows one grasp after the other.

    Args:
        config: Of the tension.
        sensors: What a working sensor shows.
        tip_of: Tool tip at robot joints (10,) [rad]: base frame, [m]. Shape (3,).
        response: Shared with the pulls, which go no further than it allows.
    """

    def __init__(
        self,
        config: TensionConfig,
        sensors: SensorConfig,
        tip_of: Callable[[Vector], Vector],
        response: GraspResponse,
    ) -> None:
        self._config, self._sensors = config, sensors
        self._tip_of, self._response = tip_of, response
        self._grasped_at: Vector | None = None  # tip; None: nothing is held
        self._pulled: tuple[Vector, float] | None = None  # joints, and the pull there [m]
        self._has_seen_empty = False  # jaws, so that the next grasp is seen, too
        self._empty, self._looked = 0.0, -inf  # [N] read with empty jaws, and when last [s]
        self._reason = ""  # why nothing is believed until the release

    def pulled(self, held: Vector | None) -> float | None:
        """How far the tissue is pulled from where it was grasped [m].

        Args:
            held: Set-point [rad], shape (10,).

        Returns:
            Infinity where the grasp was not seen; None where nothing is held.
        """
        if self._grasped_at is None:
            return None
        if held is None or not self._has_seen_empty:
            return inf
        return self._pull_at(held, self._grasped_at)

    def distrust(self, words: str) -> None:
        """Take the tension as invalid until the release."""
        if self._grasped_at is not None:
            self._reason = self._reason or words

    def judge(self, measured: Measurement, held: Vector | None) -> Measurement:
        """The measurement with what is known against its tension.

        Args:
            measured: The newest.
            held: Set-point [rad], shape (10,); None: not known, the measured joints count.
        """
        if not measured.connected:
            return measured
        joints = measured.position if held is None else held
        if not measured.gripped and planning_joints(measured.position)[1] > EMPTY:
            self._grasped_at, self._reason, self._has_seen_empty = None, "", True
        elif measured.gripped and self._grasped_at is None:
            self._grasped_at = self._tip_of(joints).copy()
            self._reason, self._pulled = self._zero_error, None
            self._response.grasp()
        if self._grasped_at is None:
            self._average_empty(measured)
        elif measured.gripped and not measured.tension_invalid_reason:
            self._follow(measured, self._pull_at(joints, self._grasped_at))
        reason = self._zero_error if self._grasped_at is None else self._reason
        if not reason or measured.tension_invalid_reason:
            return measured
        return replace(measured, tension_invalid_reason=reason)

    def _follow(self, measured: Measurement, pull: float) -> None:
        if self._config.source != "none":
            self._response.update(measured.stamp, pull, measured.tension)
        if self._response.objection is not None:
            self.distrust(self._response.objection.words)

    def _pull_at(self, joints: Vector, grasped_at: Vector) -> float:
        """Distance of the tip from the grasp [m]; at rest, joints are the same object."""
        if self._pulled is None or self._pulled[0] is not joints:
            away = self._tip_of(joints) - grasped_at
            self._pulled = joints, float(np.linalg.norm(away))
        return self._pulled[1]

    def _average_empty(self, measured: Measurement) -> None:
        kept = exp(-max(0.0, measured.stamp - self._looked) / AVERAGE)
        self._looked = measured.stamp
        self._empty = kept * self._empty + (1.0 - kept) * measured.tension

    @property
    def _zero_error(self) -> str:
        """What is wrong with the tension that empty jaws read; empty: nothing."""
        allowed = self._sensors.tension_zero
        if self._config.source != "sensor" or self._empty <= allowed:
            return ""
        return f"tension {self._empty:.2f} N with nothing held, allowed {allowed:.2f} N"
