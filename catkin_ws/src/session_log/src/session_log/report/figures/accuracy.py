# SPDX-License-Identifier: BSD-3-Clause
"""Share of phrases that were taken as they were meant, by command: the paper's figure 4."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from session_log.report.bounds import Bounded
from session_log.report.figures.figure import PoolFigure
from session_log.report.figures.style import (
    BLUE,
    INK,
    PALE,
    QUIET,
    SOUND,
    Layout,
    new_figure,
    write_at_right,
)
from session_log.report.pool.pool import Pool
from session_log.report.session.trials import NO_COMMAND
from session_log.report.tables.text_table import percent


class AccuracyFigure(PoolFigure):
    """One bar per command with its confidence interval."""

    name = "accuracy"
    title = "Recognition accuracy"
    lacking = (
        "Nobody recorded what was meant to be said, so accuracy is unknown. A program that plays "
        "or prompts phrases publishes each on /voice_assist/intended as it begins to sound."
    )

    def can_draw(self, material: Pool) -> bool:
        """Whether it is known what was meant."""
        return any(material.accuracy(c).meant for c in (*material.commands, NO_COMMAND))

    def caption(self, material: Pool) -> str:
        """Name the share over all commands."""
        words = "Share of phrases taken as they were meant, with exact 95 % confidence intervals "
        words += "(Clopper-Pearson) and counts."
        hits, total, share = material.accuracy()
        if total:
            words += (
                f" All commands: {hits} of {total}, {percent(share.value)} "
                f"({share.low * 100:.1f} to {share.high * 100:.1f} %)."
            )
        return words

    def draw(self, material: Pool, layout: Layout) -> Figure:
        """Draw bars in percent."""
        commands = [c for c in material.commands if material.accuracy(c).meant]
        bars = [(c, material.accuracy(c), BLUE) for c in commands]
        if len(commands) > 1:
            bars.append(("all commands", material.accuracy(), QUIET))
        if material.accuracy(NO_COMMAND).meant:
            bars.append((NO_COMMAND, material.accuracy(NO_COMMAND), SOUND))
        figure = new_figure(layout, 0.6 + 0.27 * len(bars))
        ax = figure.subplots()
        for y, (_, (hits, total, share), color) in enumerate(bars):
            _draw_bar(ax, y, share, color)
            write_at_right(ax, y, f"{hits}/{total}")
        ax.set_yticks(range(len(bars)), [name for name, *_ in bars], parse_math=False)
        ax.set_ylim(len(bars) - 0.5, -0.5)
        ax.set_xlim(0.0, 100.0)
        ax.set_xlabel("taken as meant [%]")
        ax.tick_params(axis="y", length=0)
        ax.grid(axis="x", color=PALE, lw=0.6, zorder=0)
        return figure


def _draw_bar(ax: Axes, y: int, share: Bounded, color: str) -> None:
    value, low, high = (v * 100.0 for v in (share.value, share.low, share.high))
    ax.barh(y, value, height=0.6, color=color, alpha=0.75, lw=0, zorder=2)
    ax.plot([low, high], [y, y], color=INK, lw=1.2, zorder=3, clip_on=False)
    for end in (low, high):
        ax.plot([end, end], [y - 0.16, y + 0.16], color=INK, lw=1.2, zorder=3, clip_on=False)
