# SPDX-License-Identifier: BSD-3-Clause
"""The figures of a report, one per file, in the order in which they are shown."""

from session_log.report.figures.figure import Material, SessionFigure
from session_log.report.figures.joints import Joints
from session_log.report.figures.latency import Latency
from session_log.report.figures.loops import Loops
from session_log.report.figures.pictures import Pictures
from session_log.report.figures.rcm import RcmError
from session_log.report.figures.tension import Tension
from session_log.report.figures.timeline import Timeline

FIGURES: tuple[SessionFigure, ...] = (
    Timeline(),
    Latency(),
    RcmError(),
    Tension(),
    Pictures(),
    Joints(),
    Loops(),
)

__all__ = ["FIGURES", "Material", "SessionFigure"]
