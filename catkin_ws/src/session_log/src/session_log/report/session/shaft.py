# SPDX-License-Identifier: BSD-3-Clause
"""RCM error from the joint states alone: what the robot did, whatever the controller says."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from session_log.config import ReportConfig
from session_log.report.session.kinematics import ModelUnfit, poses
from session_log.report.session.session_data import (
    MOVING,
    RecordedTrocar,
    SessionData,
    Span,
    Track,
)


@dataclass(frozen=True, eq=False)
class JointRcm:
    """RCM error over time, or why there is none."""

    time: Track  # (n,), [s]
    error: Track  # (n,), [m] distance of the shaft's line from the trocar; nan while outside
    moving: NDArray[np.bool_]  # (n,)
    peak_time: Track  # (m,), [s]
    peak: Track  # (m,), [m] largest of all joint states in each sample period
    largest: float  # [m] of all joint states while moving, tool inside
    lacking: str = ""  # why it cannot be computed; empty when it was

    @property
    def curve(self) -> tuple[Track, Track]:
        """Times [s] and errors [m], samples and peaks in order of time. Shape (n + m,) each."""
        time = np.concatenate([self.time, self.peak_time])
        order = np.argsort(time, kind="stable")
        return time[order], np.concatenate([self.error, self.peak])[order]

    @property
    def while_moving(self) -> Track:
        """Errors while the robot moves with the tool inside [m]."""
        return self.error[self.moving & np.isfinite(self.error)]


def rcm_from_joints(data: SessionData, config: ReportConfig) -> JointRcm:
    """Distance of the shaft from the trocar, from recorded joints and robot model."""
    try:
        return _rcm(data, config)
    except ModelUnfit as error:
        return _none(error.why)


def is_moving(time: Track, states: Sequence[Span]) -> NDArray[np.bool_]:
    """Whether the robot moved, at each time [s]. Shape (n,), as of `time`."""
    found = np.zeros(len(time), dtype=bool)
    for span in states:
        if span.word in MOVING:
            found |= (time >= span.start) & (time < span.end)
    return found


def rcm_errors(
    time: Track,
    q: Mapping[str, Track],
    urdf: str,
    trocars: Sequence[RecordedTrocar],
    config: ReportConfig,
) -> Track:
    """Distance of the shaft's line from the trocar [m]; nan while the tip is not past it.

    Args:
        time: [s]. Shape (n,).
        q: Position of each joint by its name [rad]. Each of shape (n,).
        urdf: Text of the robot model.
        trocars: At least those in force at these times.
        config: Settings of the report.

    Returns:
        Shape (n,).

    Raises:
        ModelUnfit: There is no model or trocar, or these do not fit.
    """
    links = config.shaft
    if not urdf:
        raise ModelUnfit("no robot model (/robot_description)")
    if not trocars:
        raise ModelUnfit(f"no trocar ({config.topics.trocar})")
    frames = {t.frame for t in trocars} - {links.base, ""}
    if frames:
        where = ", ".join(sorted(frames))
        raise ModelUnfit(f"the trocar is given in {where}, not in {links.base}")
    shaft = poses(urdf, links.base, links.link, q, (2, 3))[:, :3]  # its z axis, its origin
    tip = poses(urdf, links.base, links.tip, q, (3,))[:, :3, 0]
    direction, origin = shaft[..., 0], shaft[..., 1]
    offset = _trocars(trocars, time) - origin  # (n, 3)
    along = np.einsum("ij,ij->i", offset, direction)
    error = np.linalg.norm(offset - along[:, None] * direction, axis=1)
    error[np.einsum("ij,ij->i", tip - origin, direction) < along] = np.nan
    return error


def _rcm(data: SessionData, config: ReportConfig) -> JointRcm:
    joints = data.joints
    if joints is None or not len(joints):
        return _none("no joint states")
    time, q = joints["time"], {name: joints[name] for name in joints.columns[1:]}
    error = rcm_errors(time, q, data.urdf, data.trocars, config)
    peak_time, peak = data.rcm_peaks["time"], data.rcm_peaks["error"]
    moving = is_moving(time, data.states)
    errors = np.concatenate([error[moving], peak[is_moving(peak_time, data.states)]])
    largest = float(np.nanmax(errors, initial=-math.inf))
    return JointRcm(time, error, moving, peak_time, peak, largest)


def _trocars(trocars: Sequence[RecordedTrocar], time: Track) -> Track:
    """Trocar at each time [m]; the first one also before it was heard. Shape (n, 3)."""
    known = sorted(trocars, key=lambda t: t.time)
    index = np.searchsorted([t.time for t in known], time, side="right") - 1
    return np.array([t.position for t in known])[index.clip(0)]


def _none(why: str) -> JointRcm:
    nothing = np.empty(0)
    return JointRcm(nothing, nothing, nothing > 0, nothing, nothing, -math.inf, why)
