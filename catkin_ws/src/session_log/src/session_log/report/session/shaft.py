# SPDX-License-Identifier: BSD-3-Clause
"""RCM error from the joint states alone: what the robot did, whatever the controller says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from session_log.config import ReportConfig
from session_log.report.session.kinematics import ModelUnfit, poses
from session_log.report.session.session_data import MOVING, SessionData, Span, Track

NO_TRACK: Track = np.empty(0)


@dataclass(frozen=True, eq=False)
class JointRcm:
    """RCM error over time, or why there is none."""

    time: Track  # (n,), [s]
    error: Track  # (n,), [m] distance of the shaft's line from the trocar; nan while outside
    moving: NDArray[np.bool_]  # (n,)
    lacking: str  # why it cannot be computed; empty when it was

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


def is_within(time: Track, spans: Sequence[Span], words: Sequence[str]) -> NDArray[np.bool_]:
    """Whether one of the words held, at each time [s]. Shape (n,), as of `time`."""
    found = np.zeros(len(time), dtype=bool)
    for span in spans:
        if span.word in words:
            found |= (time >= span.start) & (time < span.end)
    return found


def _rcm(data: SessionData, config: ReportConfig) -> JointRcm:
    joints, links = data.joints, config.shaft
    if joints is None or not len(joints):
        return _none("no joint states")
    if not data.urdf:
        return _none("no robot model (/robot_description)")
    if not data.trocars:
        return _none(f"no trocar ({config.topics.trocar})")
    frames = {t.frame for t in data.trocars} - {links.base, ""}
    if frames:
        return _none(f"the trocar is given in {', '.join(sorted(frames))}, not in {links.base}")
    q = {name: joints[name] for name in joints.columns[1:]}
    T_base_shaft = poses(data.urdf, links.base, links.link, q)
    T_base_tip = poses(data.urdf, links.base, links.tip, q)
    time = joints["time"]
    offset = _trocars(data, time) - T_base_shaft[:, :3, 3]  # (n, 3)
    direction = T_base_shaft[:, :3, 2]
    along = np.einsum("ij,ij->i", offset, direction)
    error = np.linalg.norm(offset - along[:, None] * direction, axis=1)
    tip = np.einsum("ij,ij->i", T_base_tip[:, :3, 3] - T_base_shaft[:, :3, 3], direction)
    error[tip < along] = np.nan  # the tip is not past the trocar
    return JointRcm(time, error, is_within(time, data.states, MOVING), "")


def _trocars(data: SessionData, time: Track) -> Track:
    """Trocar at each time [m]; the first one also before it was heard. Shape (n, 3)."""
    known = sorted(data.trocars, key=lambda t: t.time)
    index = np.searchsorted([t.time for t in known], time, side="right") - 1
    return np.array([t.position for t in known])[index.clip(0)]


def _none(why: str) -> JointRcm:
    return JointRcm(NO_TRACK, NO_TRACK, np.empty(0, dtype=bool), why)
