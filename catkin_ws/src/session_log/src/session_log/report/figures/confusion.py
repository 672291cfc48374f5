# SPDX-License-Identifier: BSD-3-Clause
"""What was meant against what it was taken for."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from session_log.report.figures.figure import PoolFigure
from session_log.report.figures.style import BLUE, INK, QUIET, RED, Layout, new_figure
from session_log.report.pool.pool import Pool
from session_log.report.session.trials import is_correct
from session_log.report.tables.pool_tables import confusion_counts

SHADES = {
    True: LinearSegmentedColormap.from_list("right", ("#ffffff", BLUE)),
    False: LinearSegmentedColormap.from_list("wrong", ("#ffffff", RED)),
}


class ConfusionFigure(PoolFigure):
    """One square per pair, shaded by its share of the row."""

    name = "confusion"
    title = "What was taken for what"
    lacking = "It is not known what was meant to be said."

    def can_draw(self, material: Pool) -> bool:
        """Whether it is known what was meant."""
        return bool(material.confusions)

    def caption(self, material: Pool) -> str:
        """Count what went wrong, and what would have moved the robot."""
        wrong = {p: n for p, n in material.confusions.items() if not is_correct(*p)}
        taken = sum(n for (_, taken), n in wrong.items() if taken in material.commands)
        return (
            "Rows: what was meant; columns: what it was taken for; blue is right, red is wrong, "
            f"darker is a larger share of the row. Wrong: {sum(wrong.values())} of "
            f"{material.confusions.total()}, of which {taken} were taken for a command that "
            "was not meant."
        )

    def draw(self, material: Pool, layout: Layout) -> Figure:
        """Draw the matrix with its counts."""
        rows, columns, counts = confusion_counts(material)
        figure = new_figure(layout, 1.15 + 0.3 * len(rows))
        ax = figure.subplots()
        for y, (row, numbers) in enumerate(zip(rows, counts, strict=True)):
            for x, (column, count) in enumerate(zip(columns, numbers, strict=True)):
                share = count / max(sum(numbers), 1)
                color = SHADES[is_correct(row, column)](0.15 + 0.75 * share if count else 0.0)
                ax.add_patch(Rectangle((x - 0.5, y - 0.5), 1, 1, fc=color, ec="#e4e7eb", lw=0.6))
                if count:
                    ink = "white" if np.mean(color[:3]) < 0.55 else INK
                    ax.text(x, y, str(count), ha="center", va="center", color=ink, fontsize=8)
        ax.set_xlim(-0.5, len(columns) - 0.5)
        ax.set_ylim(len(rows) - 0.5, -0.5)
        ax.set_yticks(range(len(rows)), rows, parse_math=False)
        turn = {"rotation": 30.0, "ha": "left"} if layout.is_wide else {"rotation": 90.0}
        ax.set_xticks(range(len(columns)), columns, parse_math=False, **turn)
        ax.xaxis.tick_top()
        ax.xaxis.set_label_position("top")
        ax.tick_params(length=0)
        ax.spines[:].set_visible(False)
        ax.set_ylabel("meant", color=QUIET)
        ax.set_xlabel("taken for", color=QUIET)
        return figure
