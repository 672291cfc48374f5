# SPDX-License-Identifier: BSD-3-Clause
"""One style for every figure: colours that colour-blind readers can tell apart, sizes, helpers."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from session_log.report.session.session_data import MOVING, SILENT, Span, Track

INK = "#1f2933"
QUIET = "#7b8794"
PALE = "#e4e7eb"
SOUND = "#b8c2cc"
BLUE, ORANGE, GREEN, RED, SKY, PURPLE = (
    "#0072B2",
    "#E69F00",
    "#009E73",
    "#D55E00",
    "#56B4E9",
    "#AA4499",
)
STATE_COLORS = {
    "standby": "#d5dae0",
    "active": "#bfe3d6",
    "moving": BLUE,
    "stopping": ORANGE,
    "halted": RED,
    "faulted": PURPLE,
}
MODE_COLORS = {"active": SKY, "standby": STATE_COLORS["standby"]}
PHASE_COLORS = ("#cfe3f1", "#e6eff6")  # in turn
RC: dict[str, Any] = {
    "font.size": 8.0,
    "axes.titlesize": 8.5,
    "axes.labelsize": 8.0,
    "axes.edgecolor": QUIET,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "legend.fontsize": 7.5,
    "legend.frameon": False,
    "text.color": INK,
    "lines.linewidth": 1.1,
    "pdf.fonttype": 42,
}


@dataclass(frozen=True)
class Layout:
    """A width for which figures are drawn: two columns of a paper, or one column and a phone."""

    width: float  # [in]
    seconds_per_row: float  # of the timeline
    columns: int  # of pictures

    @property
    def is_wide(self) -> bool:
        """Whether there is room beside things, not only below them."""
        return self.width > 5.0


WIDE = Layout(7.16, 60.0, 2)
NARROW = Layout(3.5, 24.0, 1)


def new_figure(layout: Layout, height: float) -> Figure:
    """Make a figure of the layout's width and the given height [in]."""
    return Figure(figsize=(layout.width, height), layout="constrained")


def shade_motion(ax: Axes, states: Iterable[Span]) -> None:
    """Mark when the robot moved."""
    for span in states:
        if span.word in MOVING:
            ax.axvspan(span.start, span.end, color=STATE_COLORS[span.word], alpha=0.13, lw=0)


def write_at_right(ax: Axes, y: float, words: str, color: str = INK) -> None:
    """Write beside the right edge of the axes at a height of their data."""
    ax.annotate(
        words,
        (1.0, y),
        xycoords=("axes fraction", "data"),
        xytext=(4, 0),
        textcoords="offset points",
        va="center",
        fontsize=7,
        color=color,
    )


def time_axis(ax: Axes, duration: float) -> None:
    """Label a time axis that spans the session."""
    ax.set_xlim(0.0, max(duration, 1.0))
    ax.set_xlabel("time since the session began [s]")


def with_gaps(time: Track, value: Track) -> tuple[Track, Track]:
    """Put a nan where nothing was recorded for long, so that no line leads across.

    Args:
        time: Of each sample [s]. Shape (n,).
        value: Shape (n,).

    Returns:
        Time and value with a nan wherever samples are further apart than SILENT, and than three
        usual steps of a slow topic. Shape (m,) each.
    """
    steps = np.diff(time)
    if not len(steps):
        return time, value
    gaps = np.flatnonzero(steps > max(SILENT, 3.0 * float(np.median(steps)))) + 1
    return np.insert(time, gaps, time[gaps - 1]), np.insert(value, gaps, np.nan)


def thin(time: Track, value: Track, points: int = 4000) -> tuple[Track, Track]:
    """Keep extremes of long tracks: the least and the largest of each of `points / 2` stretches.

    A stretch with values that are not finite keeps the first of them, too.
    """
    if len(time) <= points:
        return time, value
    is_known = np.isfinite(value)
    low, high = np.where(is_known, value, np.inf), np.where(is_known, value, -np.inf)
    stretch = -(-len(time) // (points // 2))
    keep = []
    for begin in range(0, len(time), stretch):
        part = slice(begin, begin + stretch)
        found = {low[part].argmin(), high[part].argmax()}
        if not is_known[part].all():
            found.add(is_known[part].argmin())
        keep += sorted(begin + int(k) for k in found)
    index = np.array(keep)
    return time[index], value[index]
