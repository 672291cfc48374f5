# SPDX-License-Identifier: BSD-3-Clause
"""Errors of the package; each stores the numbers it speaks of and names what was allowed."""

from __future__ import annotations

from typing import Final

NAMED_REASONS: Final = 3  # in the words of an error that has many


class RstError(Exception):
    """Base of everything that this package raises by itself."""


class RobotModelError(RstError):
    """The URDF is not one of this robot."""


class Infeasible(RstError):
    """No path keeps all limits; the subclasses say which one broke."""


class Unreachable(Infeasible):
    """The arm cannot take the tool all along the way with the shaft through the trocar."""

    def __init__(self, reached: float, length: float) -> None:
        super().__init__(
            f"unreachable beyond {reached * 1e3:.1f} mm of a way of {length * 1e3:.1f} mm "
            "with the shaft through the trocar"
        )
        self.reached, self.length = reached, length


class JointLimitExceeded(Infeasible):
    """A joint would leave its range."""

    def __init__(self, joint: str, value: float, lower: float, upper: float) -> None:
        super().__init__(f"{joint} at {value:.3f} rad, allowed {lower:.3f} to {upper:.3f} rad")
        self.joint, self.value, self.lower, self.upper = joint, value, lower, upper


class TrocarDrift(Infeasible):
    """The shaft would leave, or has left, the trocar by more than allowed."""

    def __init__(self, distance: float, allowed: float) -> None:
        digits = 2 if allowed >= 1e-8 else 6  # the solver's own tolerance is far below others
        super().__init__(
            f"shaft {distance * 1e6:.2f} um off the trocar, allowed {allowed * 1e6:.{digits}f} um"
        )
        self.distance, self.allowed = distance, allowed


class OutsideWorkspace(Infeasible):
    """The tool tip would leave the workspace."""

    def __init__(self, distance: float, allowed: float) -> None:
        super().__init__(
            f"tip {distance * 1e3:.1f} mm from the workspace centre, allowed {allowed * 1e3:.1f} mm"
        )
        self.distance, self.allowed = distance, allowed


class InsertionOutOfRange(Infeasible):
    """Too little or too much shaft would be inside the trocar."""

    def __init__(self, depth: float, least: float, most: float) -> None:
        super().__init__(
            f"{depth * 1e3:.1f} mm of shaft inserted, "
            f"allowed {least * 1e3:.1f} to {most * 1e3:.1f} mm"
        )
        self.depth, self.least, self.most = depth, least, most


class LongWay(Infeasible):
    """A joint or the elbow would move much further than the tool needs."""

    def __init__(self, what: str, way: str, length: float, allowed: str) -> None:
        super().__init__(
            f"{what} would move by {way} on a way of {length * 1e3:.1f} mm, allowed {allowed}"
        )
        self.what, self.length = what, length


class Collision(Infeasible):
    """Two parts of the robot, or one and what stands around it, would come too near."""

    def __init__(self, first: str, second: str, distance: float, allowed: float) -> None:
        super().__init__(
            f"{first} {distance * 1e3:.1f} mm from {second}, "
            f"allowed {allowed * 1e3:.1f} mm and more"
        )
        self.first, self.second = first, second
        self.distance, self.allowed = distance, allowed


class NearSingular(Infeasible):
    """The arm could hardly move the tool some way, with the shaft through the trocar."""

    def __init__(self, value: float, allowed: float) -> None:
        super().__init__(f"manipulability {value:.2e}, allowed {allowed:.2e} and more")
        self.value, self.allowed = value, allowed


class NoGrasp(Infeasible):
    """None of the ways that were tried to take the tissue keeps all limits.

    Its words name some of the reasons, that of the best way first.
    """

    def __init__(self, reasons: tuple[Infeasible, ...]) -> None:
        words = "; ".join(dict.fromkeys(str(reason) for reason in reasons[:NAMED_REASONS]))
        super().__init__(f"none of {len(reasons)} ways to take the tissue is free: {words}")
        self.reasons = reasons
