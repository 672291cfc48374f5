# SPDX-License-Identifier: BSD-3-Clause
"""Poses of the shaft, recorded one at a time at rest, and the trocar that they have in common."""

from __future__ import annotations

from typing import Final

import numpy as np

from rst_control.config import RcmConfig, WatchdogConfig
from rst_control.execution.orders import Reply
from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.kinematics.configuration import Configuration, planning_joints
from rst_control.kinematics.robot_model import RobotModel
from rst_control.registration.pivot_calibration import PivotFit, fit_pivot
from rst_control.registration.registrar import position_words, unrest
from rst_control.types import NOT_CONNECTED, Reason, Vector

MOST: Final = 1000  # poses that are kept


class ShaftPoses:
    """Collects where the shaft was.

    Args:
        model: The robot.
        rcm: How many poses, how far apart, and how well they must agree.
        watchdogs: When the robot counts as at rest.
    """

    def __init__(self, model: RobotModel, rcm: RcmConfig, watchdogs: WatchdogConfig) -> None:
        self._model, self._settings, self._watchdogs = model, rcm.registration, watchdogs
        self._lines: list[tuple[Vector, Vector]] = []

    def record(self, view: ControllerSnapshot, now: float) -> Reply:
        """Keep the shaft as it is measured, where the robot is healthy and at rest.

        It may have been guided by hand, which a robot's side reports until the next "hey robot".

        Args:
            view: The executor's.
            now: Time [s], the clock of the measurement.
        """
        refusal = unrest(view, now, self._watchdogs, may_be_guided=True)
        if refusal is not None or view.measurement is None:
            return Reply.refused(refusal or NOT_CONNECTED)
        if len(self._lines) >= MOST:
            words = f"{MOST} shaft poses recorded already; fit or forget them"
            return Reply(False, words, Reason.QUEUE_FULL)
        self._lines.append(shaft_line(self._model, view.measurement.position))
        words = f"{len(self._lines)} shaft poses recorded, {self._settings.min_poses} needed"
        return Reply(True, words)

    def forget(self) -> Reply:
        """Forget all of them."""
        count, self._lines = len(self._lines), []
        return Reply(True, f"{count} shaft poses forgotten")

    def fit(self) -> PivotFit:
        """The trocar that the poses have in common.

        Raises:
            PivotIllPosed: There are too few, or they are too much alike.
        """
        lines = np.array(self._lines).reshape(-1, 2, 3)
        settings = self._settings
        return fit_pivot(lines[:, 0], lines[:, 1], settings.min_poses, settings.min_spread)

    def objection(self, fit: PivotFit) -> str:
        """Why a fit is not good enough to be set; empty: it is."""
        return fit_objection(fit, self._settings.tolerance)


def shaft_line(model: RobotModel, joints: Vector) -> tuple[Vector, Vector]:
    """A point [m] and the direction of the shaft, base frame, for joints (10,) [rad]."""
    T = Configuration(model, planning_joints(joints)[0]).T_base_shaft
    return T[:3, 3], T[:3, 2]


def fit_objection(fit: PivotFit, allowed: float) -> str:
    """Why a fit is not good enough to be the trocar; empty: it is.

    Args:
        fit: Of the shaft's poses.
        allowed: Largest residual, and largest standard deviation of the point [m].
    """
    worst = int(fit.residuals.argmax())
    if not fit.largest <= allowed:
        return (
            f"shaft pose {worst + 1} is {fit.largest * 1e3:.3f} mm from the common point, "
            f"allowed {allowed * 1e3:.3f} mm"
        )
    if not fit.deviation <= allowed:
        return (
            f"standard deviation of the common point is {fit.deviation * 1e3:.3f} mm, "
            f"allowed {allowed * 1e3:.3f} mm"
        )
    return ""


def fit_words(fit: PivotFit) -> str:
    """A fit for people; poses are counted from 1."""
    outliers = ", ".join(str(n + 1) for n in fit.outliers)
    return (
        f"trocar {position_words(fit.position)} from {len(fit.residuals)} shaft poses "
        f"that spread by {np.degrees(fit.spread):.1f} deg: "
        f"residual {fit.rms * 1e3:.3f} mm rms, {fit.largest * 1e3:.3f} mm at most, "
        f"standard deviation {fit.deviation * 1e3:.3f} mm"
        + (f"; poses that contradict the others: {outliers}" if outliers else "")
    )
