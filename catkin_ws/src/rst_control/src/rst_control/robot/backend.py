# SPDX-License-Identifier: BSD-3-Clause
"""What a robot has to do to be controlled; the verbs are those of CRTK.

For a new robot write either this protocol, where it runs in the process of its caller, or a node
with the same verbs as topics: docs/reference/interfaces.md, "Between controller and robot".
"""

from __future__ import annotations

from typing import Protocol

from rst_control.types import Measurement, Setpoint


class RobotBackend(Protocol):
    """A robot of ten joints, in the order of JOINTS; the jaws are the last two."""

    def measured_js(self) -> Measurement | None:
        """Newest joint states with the force on the jaws; None: none were ever measured."""
        ...

    def servo_jp(self, setpoint: Setpoint) -> None:
        """Send one set-point of a stream; the robot holds by itself when the stream ends."""
        ...

    def hold(self) -> None:
        """Slow down and stay; set-points sent before this no longer count."""
        ...

    def clear_fault(self) -> None:
        """Ask the robot to take set-points again; it does so at rest only."""
        ...
