# SPDX-License-Identifier: BSD-3-Clause
"""What every figure of the report is given and gives back."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

from matplotlib.figure import Figure

from session_log.analysis import CommandRow
from session_log.config import ReportConfig
from session_log.report.style import Layout
from session_log.session_data import SessionData


@dataclass(frozen=True)
class Material:
    """What figures and tables are made from."""

    data: SessionData
    rows: list[CommandRow]
    config: ReportConfig

    @property
    def duration(self) -> float:
        """Length of the session [s]."""
        return self.data.survey.duration


class SessionFigure(ABC):
    """One figure: its name is also the name of its PNG."""

    name: str
    title: str
    lacking: str  # said in place of the figure when the session has nothing for it

    @abstractmethod
    def can_draw(self, material: Material) -> bool:
        """Tell whether the session has what the figure shows."""

    @abstractmethod
    def caption(self, material: Material) -> str:
        """Say what is to be seen, with the figures that matter."""

    @abstractmethod
    def draw(self, material: Material, layout: Layout) -> Figure:
        """Draw it for a layout."""
