# SPDX-License-Identifier: BSD-3-Clause
"""How far each joint moved, and how near its limits it came."""

from __future__ import annotations

import math
from xml.etree import ElementTree

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from session_log.report.figures.figure import Material, SessionFigure
from session_log.report.style import BLUE, INK, PALE, QUIET, RED, Layout, new_figure
from session_log.session_data import Track

Limits = dict[str, tuple[float, float]]
CLOSE = math.radians(5.0)  # a margin below this is drawn as a warning


class Joints(SessionFigure):
    """Range of every joint within its limits."""

    name = "joints"
    title = "Joint ranges and margins"
    lacking = "The recording holds no joint states."

    def can_draw(self, material: Material) -> bool:
        """Tell whether joint states were recorded."""
        joints = material.data.joints
        return joints is not None and len(joints) > 0

    def caption(self, material: Material) -> str:
        """Name the joint that came closest to a limit."""
        margins = joint_margins(material)
        words = "Bar: positions visited; pale: allowed by the URDF; ring: position at the end."
        if not margins:
            return words + " The recording names no joint limits."
        name = min(margins, key=lambda n: margins[n])
        return f"{words} Smallest margin: {math.degrees(margins[name]):.1f}° ({name})."

    def draw(self, material: Material, layout: Layout) -> Figure:
        """Draw one line per joint, in degrees."""
        joints, limits = material.data.joints, joint_limits(material.data.urdf)
        if joints is None:
            raise ValueError("no joint states: ask can_draw first")
        names = joints.columns[1:]
        figure = new_figure(layout, 0.6 + 0.24 * len(names))
        ax = figure.subplots()
        margins = joint_margins(material)
        for y, name in enumerate(names):
            _draw_joint(ax, y, joints[name] * 180.0 / math.pi, limits.get(name))
            margin = margins.get(name)
            words = "no limit" if margin is None else f"{math.degrees(margin):.1f}°"
            color = RED if margin is not None and margin < CLOSE else INK
            ax.annotate(
                words,
                (1.0, y),
                xycoords=("axes fraction", "data"),
                xytext=(4, 0),
                textcoords="offset points",
                va="center",
                fontsize=7,
                color=color if margin is not None else QUIET,
            )
        ax.set_yticks(range(len(names)), [n.replace("joint_", "") for n in names])
        ax.set_ylim(len(names) - 0.5, -0.5)
        ax.set_ylabel("joint")
        ax.set_xlabel("position [°]   (right: smallest margin to a limit)")
        ax.tick_params(axis="y", length=0)
        return figure


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


def joint_margins(material: Material) -> dict[str, float]:
    """Smallest distance to a limit over the session, by joint [rad]; negative is beyond it."""
    joints, limits = material.data.joints, joint_limits(material.data.urdf)
    if joints is None or not len(joints):
        return {}
    margins = {}
    for name in joints.columns[1:]:
        if name in limits:
            low, high = limits[name]
            q = joints[name]
            margins[name] = float(min((q - low).min(), (high - q).min()))
    return margins


def _draw_joint(ax: Axes, y: int, q: Track, limits: tuple[float, float] | None) -> None:

    low, high = (math.degrees(v) for v in limits) if limits else (-180.0, 180.0)
    ax.barh(y, high - low, left=low, height=0.62, color=PALE, lw=0)
    width = max(float(q.max() - q.min()), 0.8)
    ax.barh(y, width, left=float(q.min()), height=0.62, color=BLUE, lw=0)
    ax.plot(float(q[-1]), y, marker="o", ms=4, mfc="white", color=INK, mew=0.8)
