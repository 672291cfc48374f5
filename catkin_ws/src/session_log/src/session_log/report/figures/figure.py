# SPDX-License-Identifier: BSD-3-Clause
"""What every figure of the report is given and gives back."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Generic, TypeVar

from matplotlib.figure import Figure

from session_log.config import ReportConfig
from session_log.report.figures.style import Layout
from session_log.report.pool.pool import Pool
from session_log.report.session.analysis import CommandRow
from session_log.report.session.session_data import SessionData
from session_log.report.session.shaft import JointRcm
from session_log.report.session.trials import PhraseTrial


@dataclass(frozen=True)
class SessionMaterial:
    """What figures and tables of one session are made from."""

    data: SessionData
    rows: list[CommandRow]
    config: ReportConfig
    rcm: JointRcm
    trials: tuple[PhraseTrial, ...]

    @property
    def duration(self) -> float:
        """Length of the session [s]."""
        return self.data.recording.duration


M = TypeVar("M")


class ReportFigure(ABC, Generic[M]):
    """One figure of some material: its name is also the name of its PNG."""

    name: str
    title: str
    lacking: str  # said in place of the figure when there is nothing for it

    @abstractmethod
    def can_draw(self, material: M) -> bool:
        """Whether there is what the figure shows."""

    @abstractmethod
    def caption(self, material: M) -> str:
        """Say what is to be seen, with the figures that matter."""

    @abstractmethod
    def draw(self, material: M, layout: Layout) -> Figure:
        """Draw it for a layout."""


class SessionFigure(ReportFigure[SessionMaterial]):
    """One figure of one session."""


class PoolFigure(ReportFigure[Pool]):
    """One figure of one session or of many."""
