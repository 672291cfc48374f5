# SPDX-License-Identifier: BSD-3-Clause
"""How evenly the fast loops ran."""

from __future__ import annotations

from itertools import cycle

import numpy as np
from matplotlib.figure import Figure

from session_log.report.figures.figure import SessionFigure, SessionMaterial
from session_log.report.figures.style import BLUE, GREEN, ORANGE, PURPLE, SKY, Layout, new_figure
from session_log.report.session.analysis import loop_timing

COLORS = (BLUE, ORANGE, GREEN, PURPLE, SKY)


class LoopsFigure(SessionFigure):
    """Distribution of the time between consecutive stamps of the fast topics."""

    name = "loop_timing"
    title = "Loop timing"
    lacking = "The recording holds no joint states or set-points."

    def can_draw(self, material: SessionMaterial) -> bool:
        """Whether a fast topic was recorded."""
        return bool(material.data.loops)

    def caption(self, material: SessionMaterial) -> str:
        """Name the late cycles of each topic."""
        parts = []
        for loop in material.data.loops:
            timing = loop_timing(loop, material.config.late_factor)
            parts.append(
                f"{timing.topic}: median {timing.period.median * 1e3:.2f} ms, 99 % "
                f"{timing.period.p99 * 1e3:.2f} ms, longest {timing.period.largest * 1e3:.1f} ms, "
                f"{timing.late} of {timing.period.count} cycles late"
            )
        factor = material.config.late_factor
        return (
            "Time between consecutive stamps. "
            + "; ".join(parts)
            + f" (late: longer than {factor:g} medians). The last bin holds all longer ones."
        )

    def draw(self, material: SessionMaterial, layout: Layout) -> Figure:
        """Draw histograms with a logarithmic count, in milliseconds."""
        figure = new_figure(layout, 2.2)
        ax = figure.subplots()
        tracks = [
            np.frombuffer(loop.length, dtype=np.float32) * 1e3 for loop in material.data.loops
        ]
        top = 3.0 * max(float(np.median(track)) for track in tracks)
        bins = np.linspace(0.0, top, 121)
        for loop, track, color in zip(material.data.loops, tracks, cycle(COLORS)):
            ax.hist(
                np.clip(track, 0.0, top),
                bins.tolist(),
                histtype="step",
                color=color,
                lw=1.1,
                label=loop.topic,
            )
        ax.set_yscale("log")
        ax.set_ylim(bottom=0.7)
        ax.set_xlim(0.0, top)
        ax.set_xlabel("time between messages [ms]")
        ax.set_ylabel("messages")
        ax.legend(loc="upper right")
        return figure
