# SPDX-License-Identifier: BSD-3-Clause
"""Errors of the package; each stores the numbers it speaks of and names what was allowed."""

from __future__ import annotations


class RstError(Exception):
    """Base of everything that this package raises by itself."""


class RobotModelError(RstError):
    """The URDF is not one of this robot."""


class UnknownLimitLayerError(RstError):
    """limits.yaml asks for a layer that it does not define."""

    def __init__(self, name: str, known: tuple[str, ...]) -> None:
        super().__init__(f"limit layer {name!r}, allowed: {', '.join(known)}")
        self.name, self.known = name, known


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
        super().__init__(
            f"shaft {distance * 1e6:.2f} um off the trocar, allowed {allowed * 1e6:.2f} um"
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
