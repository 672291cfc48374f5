# SPDX-License-Identifier: BSD-3-Clause
"""RCM error over time with its limit."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from session_log.analysis import rcm_above, rcm_while_moving
from session_log.report.figures.figure import Material, SessionFigure
from session_log.report.style import BLUE, RED, Layout, new_figure, shade_motion, thin, time_axis

SMALL = 20.0  # an error this many times below the limit is drawn on a logarithmic scale
LEAST = 1e-6  # [µm] where that scale begins at the latest


def micrometres(value: float) -> str:
    """Write a length [m] in micrometres, three digits."""
    return f"{value * 1e6:.3g} µm"


class RcmError(SessionFigure):
    """Distance of the measured shaft line from the trocar."""

    name = "rcm_error"
    title = "RCM error"
    lacking = "The recording holds no controller states with the tool inside the patient."

    def can_draw(self, material: Material) -> bool:
        """Tell whether the controller's state was recorded with the tool inside."""
        return bool(np.isfinite(material.data.controller["rcm_error"]).any())

    def caption(self, material: Material) -> str:
        """Name the errors while moving."""
        moving = rcm_while_moving(material.data)
        if not moving.count:
            return "Distance of the measured shaft line from the trocar. The robot did not move."
        limit = material.config.rcm_limit
        above = rcm_above(material.data, limit)
        return (
            "Distance of the measured shaft line from the trocar; shaded while the robot moves. "
            f"While moving: RMS {micrometres(moving.rms)}, 95 % {micrometres(moving.p95)}, "
            f"largest {micrometres(moving.largest)}; {above} of {moving.count} samples above "
            f"the limit of {micrometres(limit)}."
        )

    def draw(self, material: Material, layout: Layout) -> Figure:
        """Draw error and limit in micrometres."""
        table, limit = material.data.controller, material.config.rcm_limit * 1e6
        figure = new_figure(layout, 2.2)
        ax = figure.subplots()
        shade_motion(ax, material.data.states)
        inside = np.isfinite(table["rcm_error"])
        time, error = thin(table["time"][inside], table["rcm_error"][inside] * 1e6)
        ax.plot(time, error, color=BLUE, lw=0.8)
        ax.axhline(limit, color=RED, lw=1.0, ls="--")
        ax.annotate(
            f"limit {limit:.3g} µm",
            (1.0, limit),
            xycoords=("axes fraction", "data"),
            xytext=(-2, -3),
            textcoords="offset points",
            ha="right",
            va="top",
            color=RED,
            fontsize=7.5,
        )
        largest = float(error.max())
        if 0.0 < largest < limit / SMALL:
            ax.set_yscale("log")
            typical = float(np.median(error[error > 0.0]))
            ax.set_ylim(max(typical / 10.0, LEAST), limit * 2.0)
        else:
            ax.set_ylim(0.0, max(limit, largest) * 1.12)
        ax.set_ylabel("RCM error [µm]")
        time_axis(ax, material.duration)
        return figure
