# SPDX-License-Identifier: BSD-3-Clause
"""How far each joint moved, and how near its limits it came."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

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
from session_log.report.session.joint_margins import (
    JointLimit,
    JointMargin,
    joint_limits,
    joint_margins,
    positions,
    unknown_positions,
)
from session_log.report.session.session_data import Track


@dataclass(frozen=True)
class _Unit:
    """In which the joints of a kind are drawn."""

    name: str
    factor: float  # from [rad] or [m]
    close: float  # [rad] or [m]: a margin below it is drawn as a warning
    least_bar: float  # so long is the bar of a joint that stood still

    def words(self, value: float) -> str:
        return f"{value * self.factor:.1f}{self.name}"


DEGREES = _Unit("°", 180.0 / math.pi, math.radians(5.0), 0.8)
MILLIMETRES = _Unit("\u00a0mm", 1e3, 0.005, 0.2)


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
        """Name the joints of each kind that came closest to a limit, and what is left out."""
        margins, unknown = joint_margins(material.data), unknown_positions(material.data)
        words = "Bar: positions visited; pale: allowed by the URDF; ring: position at the end."
        if not margins and not unknown:
            words += " The recording names no joint limits."
        for unit, kind in ((DEGREES, ""), (MILLIMETRES, " of a sliding joint")):
            mine = {n: m.value for n, m in margins.items() if _unit(m) is unit}
            if mine:
                name = min(mine, key=lambda n: mine[n])
                words += f" Smallest margin{kind}: {unit.words(mine[name])} ({name})."
        if unknown:
            named = ", ".join(f"{count} of {name}" for name, count in unknown.items())
            words += f" Positions that are not finite, left out: {named}."
        return words

    def draw(self, material: SessionMaterial, layout: Layout) -> Figure:
        """Draw one line per joint: in degrees, and below in millimetres those that slide."""
        joints, limits = material.data.joints, joint_limits(material.data.urdf)
        if joints is None:
            raise ValueError("no joint states: ask can_draw first")
        names = {
            unit: [n for n in joints.columns[1:] if _unit(limits.get(n)) is unit]
            for unit in (DEGREES, MILLIMETRES)
        }
        units = [unit for unit, mine in names.items() if mine]
        heights = [0.6 + 0.24 * len(names[unit]) for unit in units]
        figure = new_figure(layout, sum(heights))
        axes = figure.subplots(len(units), 1, height_ratios=heights, squeeze=False)[:, 0]
        margins = joint_margins(material.data)
        for ax, unit in zip(axes, units, strict=True):
            rows = {n: positions(material.data, joints, n) for n in names[unit]}
            _draw_joints(ax, unit, rows, limits, margins)
        return figure


def _unit(joint: JointLimit | JointMargin | None) -> _Unit:
    """That of a joint; one without limits turns."""
    return MILLIMETRES if joint is not None and joint.is_sliding else DEGREES


def _draw_joints(
    ax: Axes,
    unit: _Unit,
    rows: Mapping[str, Track],
    limits: Mapping[str, JointLimit],
    margins: Mapping[str, JointMargin],
) -> None:
    for y, (name, q) in enumerate(rows.items()):
        _draw_joint(ax, y, q * unit.factor, limits.get(name), unit)
        margin = margins.get(name)
        if margin is None:
            write_at_right(ax, y, "no limit" if len(q) else "not finite", QUIET)
        else:
            color = RED if margin.value < unit.close else INK
            write_at_right(ax, y, unit.words(margin.value), color)
    ax.set_yticks(range(len(rows)), [n.replace("joint_", "") for n in rows], parse_math=False)
    ax.set_ylim(len(rows) - 0.5, -0.5)
    ax.set_ylabel("joint")
    ax.set_xlabel(f"position [{unit.name.strip()}]   (right: smallest margin to a limit)")
    ax.tick_params(axis="y", length=0)


def _draw_joint(ax: Axes, y: int, q: Track, limit: JointLimit | None, unit: _Unit) -> None:
    low, high = (limit.low, limit.high) if limit else (-math.pi, math.pi)
    ax.barh(y, (high - low) * unit.factor, left=low * unit.factor, height=0.62, color=PALE, lw=0)
    if len(q):
        width = max(float(q.max() - q.min()), unit.least_bar)
        ax.barh(y, width, left=float(q.min()), height=0.62, color=BLUE, lw=0)
        ax.plot(float(q[-1]), y, marker="o", ms=4, mfc="white", color=INK, mew=0.8)
