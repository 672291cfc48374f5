# SPDX-License-Identifier: BSD-3-Clause
"""The figures of a report, one per file, in the order in which they are shown."""

from session_log.report.figures.accuracy import AccuracyFigure
from session_log.report.figures.confusion import ConfusionFigure
from session_log.report.figures.figure import (
    PoolFigure,
    ReportFigure,
    SessionFigure,
    SessionMaterial,
)
from session_log.report.figures.joints import JointsFigure
from session_log.report.figures.latency import LatencyFigure
from session_log.report.figures.loops import LoopsFigure
from session_log.report.figures.pictures import PicturesFigure
from session_log.report.figures.rcm import RcmErrorFigure
from session_log.report.figures.tension import TensionFigure
from session_log.report.figures.timeline import TimelineFigure

POOL_FIGURES: tuple[PoolFigure, ...] = (AccuracyFigure(), ConfusionFigure(), LatencyFigure())
SESSION_FIGURES: tuple[SessionFigure, ...] = (
    TimelineFigure(),
    RcmErrorFigure(),
    TensionFigure(),
    PicturesFigure(),
    JointsFigure(),
    LoopsFigure(),
)

__all__ = [
    "POOL_FIGURES",
    "SESSION_FIGURES",
    "PoolFigure",
    "ReportFigure",
    "SessionFigure",
    "SessionMaterial",
]
