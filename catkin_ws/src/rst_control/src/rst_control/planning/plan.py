# SPDX-License-Identifier: BSD-3-Clause
"""Parts of a motion, and what is remembered of the tissue between the jaws."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rst_control.trajectory.path import Path


class PhaseKind(Enum):
    """Parts of a motion, as `ControllerState.phase` names them.

    A new motion is made of these: its own name comes from its command.
    """

    REACH = "reach"
    CLOSE = "close"
    PULL = "pull"
    STEP = "step"
    OPEN = "open"
    EASE = "ease"
    APPROACH = "approach"
    ALIGN = "align"
    INSERT = "insert"
    WITHDRAW = "withdraw"
    CAMERA_STEP = "look"


@dataclass(frozen=True, eq=False)
class Phase:
    """One part of a motion: along a path, or the jaws while the tip stands still.

    A phase with a path goes from wherever the robot is on it to `target`; a phase without moves the
    jaws to `opening`. With a `tension` the target of s is a limit: the motion ends where the
    tension is reached, or there.
    """

    kind: PhaseKind
    path: Path | None = None  # None: the tip stands still
    start: float = 0.0  # [m], s at the start; ignored where the robot already is on the path
    target: float = 0.0  # [m], s at the end, or the furthest s when a tension is asked for
    speed: float = 0.0  # [m/s] of s, not to be exceeded
    acceleration: float = 0.0  # [m/s^2] of s, not to be exceeded: what joints can on this path
    braking: float = 0.0  # [m/s^2] of s, hardest that a stop may be; 0: as `acceleration`
    opening: float | None = None  # [rad] of the jaws at the end; None: as it is
    tension: float | None = None  # [N] to reach and hold; None: none asked for
    jaw_time: float = 0.0  # [s] that the jaws take and settle in, once the phase began; else 0

    @property
    def min_time(self) -> float:
        """Time that the phase takes at its speed [s]."""
        way = abs(self.target - self.start) / self.speed if self.speed > 0.0 else 0.0
        return way + self.jaw_time


@dataclass(frozen=True, eq=False)
class Grasp:
    """What is remembered while tissue is held: the ways out and the pull so far."""

    pull: Path  # from the grasp point along the pull direction, over all its allowed range
    retreat: Path  # from the grasp point to clear of the tissue
    s: float = 0.0  # [m] on `pull`: target if moving, else where it stands
    tension: float | None = None  # [N] target; None: placed by distance
