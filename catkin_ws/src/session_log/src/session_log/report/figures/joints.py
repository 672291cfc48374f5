# SPDX-License-Identifier: BSD-3-Clause
"""How far each joint moved, and how near its limits it came."""

from __future__ import annotations

import math

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from session_log.report.figures.figure import SessionFigure, SessionMaterial
from session_log.report.figures.style import (
    BLUE,
    INK,
    PALE,
    QUIET,
    RED,
    Layout,
    new_figure,
    write_at_right,
)
from session_log.report.session.joint_margins import joint_limits, joint_margins
from session_log.report.session.session_data import Track

CLOSE = math.radians(5.0)  # a margin below this is drawn as a warning


class JointsFigure(SessionFigure):
    """Range of every joint within its limits."""

    name = "joints"
    title = "Joint ranges and margins"
    lacking = "The recording holds no joint states."

    def can_draw(self, material: SessionMaterial) -> bool:
        """Whether joint states were recorded."""
        joints = material.data.joints
        return joints is not None and len(joints) > 0

    def caption(self, material: SessionMaterial) -> str:
        """Name the joint that came closest to a limit."""
        margins = joint_margins(material.data)
        words = "Bar: positions visited; pale: allowed by the URDF; ring: position at the end."
        if not margins:
            return words + " The recording names no joint limits."
        name = min(margins, key=lambda n: margins[n])
        return f"{words} Smallest margin: {math.degrees(margins[name]):.1f}° ({name})."

    def draw(self, material: SessionMaterial, layout: Layout) -> Figure:
        """Draw one line per joint, in degrees."""
        joints, limits = material.data.joints, joint_limits(material.data.urdf)
        if joints is None:
            raise ValueError("no joint states: ask can_draw first")
        names = joints.columns[1:]
        figure = new_figure(layout, 0.6 + 0.24 * len(names))
        ax = figure.subplots()
        margins = joint_margins(material.data)
        for y, name in enumerate(names):
            _draw_joint(ax, y, joints[name] * 180.0 / math.pi, limits.get(name))
            margin = margins.get(name)
            words = "no limit" if margin is None else f"{math.degrees(margin):.1f}°"
            color = RED if margin is not None and margin < CLOSE else INK
            write_at_right(ax, y, words, color if margin is not None else QUIET)
        shown = [n.replace("joint_", "") for n in names]
        ax.set_yticks(range(len(names)), shown, parse_math=False)
        ax.set_ylim(len(names) - 0.5, -0.5)
        ax.set_ylabel("joint")
        ax.set_xlabel("position [°]   (right: smallest margin to a limit)")
        ax.tick_params(axis="y", length=0)
        return figure


def _draw_joint(ax: Axes, y: int, q: Track, limits: tuple[float, float] | None) -> None:
    low, high = (math.degrees(v) for v in limits) if limits else (-180.0, 180.0)
    ax.barh(y, high - low, left=low, height=0.62, color=PALE, lw=0)
    width = max(float(q.max() - q.min()), 0.8)
    ax.barh(y, width, left=float(q.min()), height=0.62, color=BLUE, lw=0)
    ax.plot(float(q[-1]), y, marker="o", ms=4, mfc="white", color=INK, mew=0.8)
