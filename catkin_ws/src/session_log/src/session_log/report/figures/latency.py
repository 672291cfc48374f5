# SPDX-License-Identifier: BSD-3-Clause
"""Time from the end of speech to the robot's action, beside the paper's."""

from __future__ import annotations

import math

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from session_log.analysis import latency_by_command, statistics
from session_log.report.figures.figure import Material, SessionFigure
from session_log.report.style import BLUE, ORANGE, PALE, RED, Layout, new_figure


class Latency(SessionFigure):
    """Every command of the session as a point, its mean, and the paper's mean."""

    name = "latency"
    title = "From the end of speech to motion"
    lacking = "No spoken command led to an action."

    def can_draw(self, material: Material) -> bool:
        """Tell whether a spoken command led to an action."""
        return bool(latency_by_command(material.rows))

    def caption(self, material: Material) -> str:
        """Name the overall mean."""
        ours = statistics([row.action_latency for row in material.rows])
        paper = [entry.latency for entry in material.config.paper_latency]
        words = (
            "Time from the end of speech to the robot's action: motion started, braking began "
            "(stop) or the mode changed (hey robot, terminate). "
            f"Mean of {ours.count} commands {ours.mean:.2f} s, largest {ours.largest:.2f} s."
        )
        early = sum(1 for row in material.rows if row.heard and row.heard.is_early)
        if early:
            words += f" Decided before the end of speech was certain: {early}."
        if paper:
            mean = sum(paper) / len(paper)
            words += f" The paper: mean {mean:.2f} s on an {material.config.paper_hardware}."
        return words

    def draw(self, material: Material, layout: Layout) -> Figure:
        """Draw one line per command."""
        paper = {entry.command: entry.latency for entry in material.config.paper_latency}
        ours = latency_by_command(material.rows)
        commands = list(dict.fromkeys([*paper, *ours]))
        figure = new_figure(layout, 0.9 + 0.26 * len(commands))
        ax = figure.subplots()
        for y, command in enumerate(commands):
            ax.axhline(y, color=PALE, lw=0.6, zorder=0)
            _draw_ours(ax, material, command, y)
            if command in paper:
                ax.plot(paper[command], y, marker="D", ms=5, mfc="none", color=RED, ls="")
        _label(ax, commands)
        if not layout.is_wide:
            ax.set_xlabel("end of speech to action [s]")
        handles, labels = ax.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=4, handletextpad=0.2)
        return figure


def _draw_ours(ax: Axes, material: Material, command: str, y: int) -> None:
    mine = [r for r in material.rows if r.command == command and math.isfinite(r.action_latency)]
    if not mine:
        return
    decided = [r.decision_latency for r in mine]
    acted = [r.action_latency for r in mine]
    ax.plot(decided, [y] * len(mine), marker="|", ms=8, color=ORANGE, ls="")
    ax.plot(acted, [y] * len(mine), marker="o", ms=4.5, color=BLUE, alpha=0.55, mew=0, ls="")


def _label(ax: Axes, commands: list[str]) -> None:
    ax.plot([], [], marker="|", ms=8, color=ORANGE, ls="", label="decision")
    ax.plot([], [], marker="o", ms=4.5, color=BLUE, ls="", label="action")
    ax.plot([], [], marker="D", ms=5, mfc="none", color=RED, ls="", label="paper")
    ax.set_yticks(range(len(commands)), commands)
    ax.set_ylim(len(commands) - 0.5, -0.5)
    ax.set_xlim(left=min(0.0, ax.get_xlim()[0]))
    ax.set_xlabel("time from the end of speech to the robot's action [s]")
    ax.tick_params(axis="y", length=0)
    ax.spines["left"].set_visible(False)
