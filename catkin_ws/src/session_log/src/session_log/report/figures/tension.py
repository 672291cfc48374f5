# SPDX-License-Identifier: BSD-3-Clause
"""Pull of the tissue on the jaws over time, with its target."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from session_log.report.figures.figure import SessionFigure, SessionMaterial
from session_log.report.figures.style import (
    BLUE,
    INK,
    RED,
    Layout,
    new_figure,
    shade_motion,
    thin,
    time_axis,
    with_gaps,
)
from session_log.report.session.analysis import statistics
from session_log.report.session.session_data import SampledTable
from session_log.report.session.tension import (
    measured_tension,
    tension_error,
    tension_settings,
    tension_with_target,
)


class TensionFigure(SessionFigure):
    """Tension and the target that it was steered to."""

    name = "tension"
    title = "Tissue tension"
    lacking = "The recording holds no tension."

    def can_draw(self, material: SessionMaterial) -> bool:
        """Whether tension was measured."""
        return bool(np.isfinite(_measured(material)["tension"]).any())

    def caption(self, material: SessionMaterial) -> str:
        """Name the largest tension and its distance from the target."""
        measured = statistics(_measured(material)["tension"])
        pulled = statistics(tension_with_target(material.data))
        error = statistics(tension_error(material.data))
        words = "Force of the tissue on the jaws and its target; shaded while the robot moves. "
        words += f"Largest: {measured.largest:.2f} N."
        if pulled.count:
            words += f" With a target set: {pulled.largest:.2f} N."
        if error.count:
            words += (
                f" Distance from the target while the robot holds: mean {error.mean:.2f} N, "
                f"95 % {error.p95:.2f} N."
            )
        return words

    def draw(self, material: SessionMaterial, layout: Layout) -> Figure:
        """Draw tension and target in newtons."""
        data = material.data
        figure = new_figure(layout, 2.2)
        ax = figure.subplots()
        shade_motion(ax, data.states)
        measured = _measured(material)
        is_known = np.isfinite(measured["tension"])
        time, tension = measured["time"][is_known], measured["tension"][is_known]
        ax.plot(*thin(*with_gaps(time, tension)), color=BLUE, lw=0.9, label="measured")
        top = float(tension.max(initial=0.0))
        if len(data.controller):
            target = data.controller["target"]
            shown = with_gaps(data.controller["time"], np.where(target > 0, target, np.nan))
            ax.plot(*shown, color=INK, ls="--", lw=1.0, label="target")
            top = max(top, float(target.max()))
        if (limit := tension_settings(data).get("limit")) is not None:
            ax.axhline(limit, color=RED, lw=1.0, ls="--", label=f"limit {limit:.3g} N")
            top = max(top, limit)
        ax.set_ylim(0.0, max(top, 0.1) * 1.25)
        ax.set_ylabel("tension [N]")
        ax.legend(loc="upper right", ncols=3, borderaxespad=0.2)
        time_axis(ax, material.duration)
        return figure


def _measured(material: SessionMaterial) -> SampledTable:
    return measured_tension(material.data, material.config.topics.tension)
