# SPDX-License-Identifier: BSD-3-Clause
"""How near the joints came to the limits of the recorded robot model."""

from __future__ import annotations

import math
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from session_log.report.session.kinematics import SLIDING
from session_log.report.session.session_data import SampledTable, SessionData, Track


@dataclass(frozen=True)
class JointLimit:
    """How far a joint may go: [rad], or [m] of one that slides."""

    low: float
    high: float
    is_sliding: bool


@dataclass(frozen=True)
class JointMargin:
    """Smallest distance of a joint to a limit over the session; negative is beyond it."""

    value: float  # [rad], or [m] of one that slides
    is_sliding: bool


def joint_limits(urdf: str) -> dict[str, JointLimit]:
    """Limits of each joint that has finite ones, by its name; empty if the URDF is not one."""
    try:
        found = {}
        for joint in ElementTree.fromstring(urdf).iter("joint"):
            limit, kind = joint.find("limit"), joint.get("type")
            if limit is None or kind not in ("revolute", *SLIDING):
                continue
            low, high = float(limit.get("lower", 0.0)), float(limit.get("upper", 0.0))
            if math.isfinite(low) and math.isfinite(high):
                found[joint.get("name", "")] = JointLimit(low, high, kind in SLIDING)
    except (ElementTree.ParseError, ValueError):
        return {}
    return found


def joint_margins(data: SessionData) -> dict[str, JointMargin]:
    """Margin of each joint that has limits and finite positions, by its name."""
    if data.joints is None:
        return {}
    margins = {}
    for name, limit in joint_limits(data.urdf).items():
        if name in data.joints.columns[1:]:
            q = positions(data, data.joints, name)
            if len(q):
                nearest = min(float(q.min()) - limit.low, limit.high - float(q.max()))
                margins[name] = JointMargin(nearest, limit.is_sliding)
    return margins


def positions(data: SessionData, joints: SampledTable, name: str) -> Track:
    """Finite positions of a joint [rad], or [m]: its extremes, then its samples. Shape (n,).

    Args:
        data: Of the session.
        joints: Its samples, which have the joint.
        name: Of the joint.
    """
    q = np.concatenate([data.joint_ranges.get(name, ()), joints[name]])
    return q[np.isfinite(q)]


def smallest_margin(data: SessionData) -> float:
    """Smallest margin of the joints that turn [rad]; nan where there is none."""
    turning = (m.value for m in joint_margins(data).values() if not m.is_sliding)
    return min(turning, default=math.nan)


def unknown_positions(data: SessionData) -> dict[str, int]:
    """How many recorded positions of a joint are not finite, by its name; zeros are left out."""
    if (joints := data.joints) is None:
        return {}
    counts = {n: int(np.count_nonzero(~np.isfinite(joints[n]))) for n in joints.columns[1:]}
    return {name: count for name, count in counts.items() if count}
