# SPDX-License-Identifier: BSD-3-Clause
"""Pull of the tissue on the jaws over time, with its target."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import yaml
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
)
from session_log.report.session.analysis import statistics, tension_error, tension_with_target
from session_log.report.session.session_data import SampledTable


class TensionFigure(SessionFigure):
    """Tension and the target that it was steered to."""

    name = "tension"
    title = "Tissue tension"
    lacking = "The recording holds no tension."

    def can_draw(self, material: SessionMaterial) -> bool:
        """Whether tension was recorded."""
        return len(material.data.tension) > 0 or len(material.data.controller) > 0

    def caption(self, material: SessionMaterial) -> str:
        """Name the largest tension and its distance from the target."""
        pulled = statistics(tension_with_target(material.data))
        error = statistics(tension_error(material.data))
        words = "Force of the tissue on the jaws and its target; shaded while the robot moves."
        if pulled.count:
            words += f" Largest with a target set: {pulled.largest:.2f} N."
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
        measured: SampledTable = data.tension if len(data.tension) else data.controller
        is_known = np.isfinite(measured["tension"])
        time, tension = thin(measured["time"][is_known], measured["tension"][is_known])
        ax.plot(time, tension, color=BLUE, lw=0.9, label="measured")
        top = float(tension.max(initial=0.0))
        if len(data.controller):
            target = data.controller["target"]
            shown = np.where(target > 0, target, np.nan)
            ax.plot(data.controller["time"], shown, color=INK, ls="--", lw=1.0, label="target")
            top = max(top, float(target.max()))
        if (limit := tension_limit(data.recording.condition.latest("parameters"))) is not None:
            ax.axhline(limit, color=RED, lw=1.0, ls="--", label=f"limit {limit:.3g} N")
            top = max(top, limit)
        ax.set_ylim(0.0, max(top, 0.1) * 1.25)
        ax.set_ylabel("tension [N]")
        ax.legend(loc="upper right", ncols=3, borderaxespad=0.2)
        time_axis(ax, material.duration)
        return figure


def tension_limit(parameters: Mapping[str, str]) -> float | None:
    """Tension at which the recorded controller stops [N]; None if its settings name none.

    Args:
        parameters: The recorded parameters, by their first name.
    """
    for text in parameters.values():
        try:
            found = _limit_in(yaml.safe_load(text)) if "tension:" in text else None
        except yaml.YAMLError:
            continue
        if found is not None:
            return found
    return None


def _limit_in(settings: Any) -> float | None:
    if not isinstance(settings, dict):
        return None
    tension = settings.get("tension")
    if isinstance(tension, dict) and isinstance(limit := tension.get("limit"), (int, float)):
        return float(limit)
    return next((v for v in map(_limit_in, settings.values()) if v is not None), None)
