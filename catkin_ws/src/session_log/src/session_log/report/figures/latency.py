# SPDX-License-Identifier: BSD-3-Clause
"""Time from the end of speech to the robot's action, beside the paper's."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from session_log.report.bounds import quantile
from session_log.report.figures.figure import PoolFigure
from session_log.report.figures.style import BLUE, INK, ORANGE, PALE, RED, Layout, new_figure
from session_log.report.pool.pool import Pool

FEW = 8  # so many points of a command stand on its line; more are strewn about it
STREWN = 0.26  # of a line's height, to either side
MOST_POINTS = 500  # drawn of a command; more are thinned evenly by rank


class LatencyFigure(PoolFigure):
    """Every command as a point, their median, and the paper's mean."""

    name = "latency"
    title = "From the end of speech to motion"
    lacking = "No spoken command led to an action."

    def can_draw(self, material: Pool) -> bool:
        """Whether a spoken command led to an action."""
        return bool(material.latencies().action)

    def caption(self, material: Pool) -> str:
        """Name the overall mean."""
        ours = material.latencies().action
        paper = [entry.latency for entry in material.config.paper.latency]
        words = (
            "Time from the end of speech, as the recogniser found it, to the robot's action: "
            "motion started, braking began (stop) or the mode changed (hey robot, terminate). "
            f"Mean of {len(ours)} commands {sum(ours) / len(ours):.2f} s, largest {ours[-1]:.2f} s."
        )
        if material.early:
            words += f" Decided before the end of speech was certain: {material.early}."
        if paper:
            mean = sum(paper) / len(paper)
            words += f" The paper: mean {mean:.2f} s on an {material.config.paper.hardware}."
        return words

    def draw(self, material: Pool, layout: Layout) -> Figure:
        """Draw one line per command, in seconds."""
        paper = {entry.command: entry.latency for entry in material.config.paper.latency}
        commands = [c for c in material.commands if c in paper or material.latencies(c).action]
        figure = new_figure(layout, 0.9 + 0.28 * len(commands))
        ax = figure.subplots()
        for y, command in enumerate(commands):
            ax.axhline(y, color=PALE, lw=0.6, zorder=0)
            times = material.latencies(command)
            _draw_points(ax, y, times.decision, "|", ORANGE)
            _draw_points(ax, y, times.action, "o", BLUE)
            if times.action:
                middle = quantile(times.action, 0.5).value
                ax.plot([middle] * 2, [y - 0.34, y + 0.34], color=INK, lw=1.4, zorder=4)
            if command in paper:
                ax.plot(paper[command], y, marker="D", ms=5, mfc="none", color=RED, ls="")
        _label(ax, commands, layout)
        handles, labels = ax.get_legend_handles_labels()
        columns = 4 if layout.is_wide else 2
        figure.legend(handles, labels, loc="outside upper center", ncols=columns, handletextpad=0.2)
        return figure


def _draw_points(ax: Axes, y: int, times: Sequence[float], marker: str, color: str) -> None:
    last, count = len(times) - 1, min(len(times), MOST_POINTS)
    shown = np.asarray(times)[np.linspace(0, last, count).round().astype(int)]
    strewn = np.zeros(len(shown))
    if len(shown) > FEW:  # the same each time, and no two neighbours at the same height
        strewn = STREWN * (2.0 * np.modf(0.618 * np.arange(len(shown)))[0] - 1.0)
    size, alpha = (8.0, 0.8) if marker == "|" else (4.0, 0.55)
    width = 1.0 if marker == "|" else 0.0
    ax.plot(shown, y + strewn, marker, ms=size, color=color, alpha=alpha, mew=width)


def _label(ax: Axes, commands: Sequence[str], layout: Layout) -> None:
    ax.plot([], [], marker="|", ms=8, color=ORANGE, ls="", label="decision")
    ax.plot([], [], marker="o", ms=4.5, color=BLUE, ls="", label="action")
    ax.plot([], [], marker="|", ms=9, mew=1.4, color=INK, ls="", label="median of action")
    ax.plot([], [], marker="D", ms=5, mfc="none", color=RED, ls="", label="paper, mean")
    ax.set_yticks(range(len(commands)), commands, parse_math=False)
    ax.set_ylim(len(commands) - 0.5, -0.5)
    ax.set_xlim(left=min(0.0, ax.get_xlim()[0]))
    wide = "time from the end of speech to the robot's action [s]"
    ax.set_xlabel(wide if layout.is_wide else "end of speech to action [s]")
    ax.tick_params(axis="y", length=0)
    ax.spines["left"].set_visible(False)
