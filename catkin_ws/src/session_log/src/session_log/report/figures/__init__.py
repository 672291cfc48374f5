# SPDX-License-Identifier: BSD-3-Clause
"""The figures of a report, one per file, in the order in which they are shown."""

from session_log.report.figures.accuracy import Accuracy
from session_log.report.figures.confusion import Confusion
from session_log.report.figures.figure import Material, PoolFigure, ReportFigure, SessionFigure
from session_log.report.figures.joints import Joints
from session_log.report.figures.latency import Latency
from session_log.report.figures.loops import Loops
from session_log.report.figures.pictures import Pictures
from session_log.report.figures.rcm import RcmError
from session_log.report.figures.tension import Tension
from session_log.report.figures.timeline import Timeline

POOL_FIGURES: tuple[PoolFigure, ...] = (Accuracy(), Confusion(), Latency())
SESSION_FIGURES: tuple[SessionFigure, ...] = (
    Timeline(),
    RcmError(),
    Tension(),
    Pictures(),
    Joints(),
    Loops(),
)

__all__ = [
    "POOL_FIGURES",
    "SESSION_FIGURES",
    "Material",
    "PoolFigure",
    "ReportFigure",
    "SessionFigure",
]
