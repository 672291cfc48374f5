# SPDX-License-Identifier: BSD-3-Clause
"""Whether the robot is fit to move, from its newest measurement alone."""

from __future__ import annotations

import numpy as np

from rst_control.types import JOINTS, NOT_CONNECTED, Cause, Measurement, Reason, robot_fault


def robot_unfit(measured: Measurement | None, now: float, max_age: float) -> Cause | None:
    """Why a robot cannot be relied on; None where it is connected, recent and without a fault.

    Args:
        measured: Newest of the robot; None: it has sent nothing yet.
        now: Time [s], the clock of the measurement.
        max_age: Of the measurement [s].
    """
    if measured is None or not measured.connected:
        return NOT_CONNECTED
    fault = robot_fault(measured.fault)
    if (age := now - measured.stamp) > max_age:
        words = f"joint states stale, {age * 1e3:.0f} ms old, allowed {max_age * 1e3:.0f} ms"
        return Cause(Reason.STALE, f"{words}: {fault.words}" if fault.words else words)
    return Cause(fault.reason, f"robot fault: {fault.words}") if measured.fault else None


def joint_in_motion(measured: Measurement, max_speed: float) -> Cause | None:
    """Which joint moves faster than allowed [rad/s]; None where all are at rest."""
    speeds = np.abs(measured.velocity)
    worst = int(speeds.argmax())
    if speeds[worst] <= max_speed:
        return None
    words = f"not at rest: {JOINTS[worst]} at {speeds[worst]:.3f} rad/s, allowed {max_speed:.3f}"
    return Cause(Reason.NOT_AT_REST, words)
