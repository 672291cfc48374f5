# SPDX-License-Identifier: BSD-3-Clause
"""The executor's parts as one view for other threads."""

from __future__ import annotations

from rst_control.execution.event_log import Ledger
from rst_control.execution.orders import View
from rst_control.execution.setpoint import Mover
from rst_control.planning.patient_surface import TrocarPose
from rst_control.types import Cause, ControllerMode, Measurement


def view_of(
    now: float,
    mode: ControllerMode,
    serial: int,
    mover: Mover,
    ledger: Ledger,
    trocar_pose: TrocarPose,
    measured: Measurement | None,
    health: Cause | None,
) -> View:
    """What the executor looks like after a tick.

    Args:
        now: Time of the tick [s].
        mode: Its state.
        serial: Number of this situation.
        mover: Motion, set-point and grasp.
        ledger: Command and last refusal.
        trocar_pose: Of the measured joints.
        measured: Newest from the robot.
        health: Why no motion would be accepted; None: it would.
    """
    motion, place = mover.motion, mover.place
    holds = measured is not None and measured.gripped
    return View(
        stamp=now,
        mode=mode,
        serial=serial,
        motion=None if motion is None else motion.glimpse,
        plan=None if motion is None else motion.plan,
        path=place.path if place else None,
        path_position=place.state.s if place else 0.0,
        command=ledger.command,
        trocar_pose=trocar_pose,
        measurement=measured,
        setpoint=mover.held,
        grasp=mover.grasp if holds else None,
        last_refusal=ledger.last_refusal,
        health=health,
    )
