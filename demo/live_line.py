# SPDX-License-Identifier: BSD-3-Clause
"""The line below the timeline: what is so now."""

from __future__ import annotations

from typing import Protocol

from rich.text import Text


class RobotState(Protocol):
    """What the line shows of the controller's state."""

    state: str
    phase: str
    progress: float
    tension: float
    rcm_error: float


def live_line(time: float, mode: str, robot: RobotState | None, partial: str) -> Text:
    """One line, cut at the edge of the terminal.

    Args:
        time: Of the script [s].
        mode: Of the voice node.
        robot: State of the controller; None: it has not published one.
        partial: Transcript of an utterance that still grows; "star" may become "stop".
    """
    line = Text(f"{time:7.2f} s  voice {mode} | ", "reverse", no_wrap=True, overflow="ellipsis")
    if robot is None:
        line.append("waiting for the controller")
    else:
        line.append(f"{robot.state} {robot.phase} {robot.progress:4.0%}")
        line.append(
            f" | tension {robot.tension:5.2f} N | RCM error {robot.rcm_error * 1e6:5.1f} um"
        )
    if partial:
        line.append(f' | perhaps "{partial} ..."', "italic dim")
    return line
