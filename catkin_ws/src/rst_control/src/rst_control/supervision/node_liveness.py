# SPDX-License-Identifier: BSD-3-Clause
"""Who has to be there for a motion to go on, and what has become of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

MASTER: Final = "ROS master"  # no node has this name, for names have no spaces


class NodeLiveness:
    """What one thread found of the others, as the control loop reads it.

    The ROS master has to be there for anything to move: without it nobody new could stop the robot.
    The node that asked for a motion has to be there for as long as it lasts.
    """

    def __init__(self) -> None:
        self._lost: Mapping[str, str] = {}

    def report(self, lost: Mapping[str, str]) -> None:
        """Note who is lost, and how, in words; all others are there, or unknown."""
        self._lost = dict(lost)

    def of(self, name: str) -> str:
        """What has become of the master or a node; empty: it is there, or nothing is known."""
        return self._lost.get(name, "")
