# SPDX-License-Identifier: BSD-3-Clause
"""The seam between the controller and whatever moves the joints; its verbs are those of CRTK."""

from __future__ import annotations

from typing import Protocol

from rst_control.types import Measurement, Setpoint


class RobotBackend(Protocol):
    """A robot of ten joints, in the order of JOINTS; the jaws are the last two."""

    def measured_js(self) -> Measurement:
        """Newest joint states, with the force on the jaws; its stamp says how old it is."""
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
