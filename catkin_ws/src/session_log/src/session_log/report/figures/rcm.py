# SPDX-License-Identifier: BSD-3-Clause
"""RCM error over time with its limit: as the controller says, and from the joint states."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from session_log.report.figures.figure import SessionFigure, SessionMaterial
from session_log.report.figures.style import (
    BLUE,
    ORANGE,
    RED,
    Layout,
    new_figure,
    shade_motion,
    thin,
    time_axis,
    with_gaps,
)
from session_log.report.session.analysis import rcm_while_moving, statistics
from session_log.report.session.session_data import Track
from session_log.report.tables.text_table import length

SMALL = 20.0  # an error this many times below the limit is drawn on a logarithmic scale
FLOOR = 0.01  # [µm] where that scale begins at the latest: below it is rounding
WHAT = "Distance of the measured shaft line from the trocar"


class RcmErrorFigure(SessionFigure):
    """Distance of the measured shaft line from the trocar."""

    name = "rcm_error"
    title = "RCM error"
    lacking = "The recording holds no moment with the tool inside the patient."

    def can_draw(self, material: SessionMaterial) -> bool:
        """Whether either error is known at some time."""
        stated = material.data.controller["rcm_error"]
        return bool(np.isfinite(stated).any() or np.isfinite(material.rcm.error).any())

    def caption(self, material: SessionMaterial) -> str:
        """Name the errors while moving, by either way."""
        words = [f"{WHAT}; shaded while the robot moves."]
        stated, own = rcm_while_moving(material.data), material.rcm.while_moving
        is_stated = np.isfinite(stated).any()
        if not is_stated and not len(own):
            words.append("The robot did not move.")
        if is_stated:
            words.append("By the controller, " + _errors(stated, material.config.rcm_limit))
        if len(own):
            words.append("From the joint states, by the recorded robot model and trocar alone, ")
            words[-1] += _errors(own, material.config.rcm_limit, material.rcm.largest)
        if material.rcm.lacking:
            words.append(_not_computed(material))
        return " ".join(words)

    def draw(self, material: SessionMaterial, layout: Layout) -> Figure:
        """Draw errors and limit in length."""
        table, limit = material.data.controller, material.config.rcm_limit * 1e6
        figure = new_figure(layout, 2.3)
        ax = figure.subplots()
        shade_motion(ax, material.data.states)
        tracks = [
            _draw_track(ax, table["time"], table["rcm_error"], "by the controller", BLUE, 1.8),
            _draw_track(ax, *material.rcm.curve, "from joint states", ORANGE),
        ]
        error = np.concatenate(tracks)
        ax.axhline(limit, color=RED, lw=1.0, ls="--", label=f"limit {limit:.3g} µm")
        largest = float(error.max())
        if 0.0 < largest < limit / SMALL:
            ax.set_yscale("log")
            typical = float(np.median(error[error > 0.0]))
            floor = max(typical / 10.0, FLOOR)
            ax.set_ylim(floor, limit * 2.0)
            for line in ax.lines:  # what is less stands on the axis
                line.set_ydata(np.maximum(line.get_ydata(), floor))
        else:
            ax.set_ylim(0.0, max(limit, largest) * 1.12)
        ax.set_ylabel("RCM error [µm]")
        time_axis(ax, material.duration)
        columns = 3 if layout.is_wide else 2
        figure.legend(loc="outside upper center", ncols=columns)
        return figure


def why_no_error(material: SessionMaterial) -> str:
    """What is said in place of the figure: what was not recorded, or that the tool was outside."""
    words, has_state = [], len(material.data.controller) > 0
    if has_state or not material.rcm.lacking:
        words.append(RcmErrorFigure.lacking)
    if not has_state:
        words.append("No state of the controller was recorded.")
    if material.rcm.lacking:
        words.append(_not_computed(material))
    return " ".join(words)


def _not_computed(material: SessionMaterial) -> str:
    return f"Not computed from the joint states: {material.rcm.lacking}."


def _errors(error: Track, limit: float, largest: float = -math.inf) -> str:
    """In words; `largest` is that of all messages, where `error` are samples of them."""
    found = statistics(error)
    above = int(np.count_nonzero(error > limit))
    return (
        f"while moving: RMS {length(found.rms)}, 95 % {length(found.p95)}, "
        f"largest {length(max(found.largest, largest))}; {above} of {found.count} samples above "
        f"the limit of {length(limit)}."
    )


def _draw_track(
    ax: Axes, time: Track, error: Track, label: str, color: str, width: float = 0.7
) -> Track:
    inside = np.isfinite(error)
    if not inside.any():
        return np.empty(0)
    micro = error[inside] * 1e6
    ax.plot(*thin(*with_gaps(time[inside], micro)), color=color, lw=width, label=label)
    return micro
