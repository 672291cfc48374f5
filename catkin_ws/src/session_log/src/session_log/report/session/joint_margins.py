# SPDX-License-Identifier: BSD-3-Clause
"""How near the joints came to the limits of the recorded robot model."""

from __future__ import annotations

from xml.etree import ElementTree

from session_log.report.session.session_data import SessionData

Limits = dict[str, tuple[float, float]]


def joint_limits(urdf: str) -> Limits:
    """Lower and upper limit of each joint that has them [rad]; empty if the URDF is not one."""
    try:
        joints = ElementTree.fromstring(urdf).iter("joint") if urdf else iter(())
        found = {}
        for joint in joints:
            limit = joint.find("limit")
            if limit is not None and joint.get("type") in ("revolute", "prismatic"):
                name = joint.get("name", "")
                found[name] = (float(limit.get("lower", 0.0)), float(limit.get("upper", 0.0)))
    except (ElementTree.ParseError, ValueError):
        return {}
    return found


def joint_margins(data: SessionData) -> dict[str, float]:
    """Smallest distance to a limit over the session, by joint [rad]; negative is beyond it."""
    joints, limits = data.joints, joint_limits(data.urdf)
    if joints is None or not len(joints):
        return {}
    margins = {}
    for name in joints.columns[1:]:
        if name in limits:
            low, high = limits[name]
            q = joints[name]
            margins[name] = float(min((q - low).min(), (high - q).min()))
    return margins
