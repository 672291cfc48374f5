# SPDX-License-Identifier: BSD-3-Clause
"""Situations for verification, from a few words."""

import numpy as np

from rst_control.commands.request import Request, Situation
from rst_control.commands.table import COMMANDS
from rst_control.types import Cause, ControllerMode, Measurement, Reason, State

NOW = 100.0


def measurement(joints, *, age=0.002, tension=0.0, speed=0.0, **more):
    return Measurement(
        position=joints,
        velocity=np.full(10, speed),
        effort=np.zeros(10),
        stamp=NOW - age,
        force=np.array([0.0, 0.0, -tension]),
        **more,
    )


def request(words, tension=0.0, distance=0.0):
    return Request(COMMANDS[words], tension, distance)


def mode_of(is_active=True, is_moving=False, halt_reason=""):
    """Mode of the controller from a few words."""
    state = State.ACTIVE if is_active else State.STANDBY
    if halt_reason:
        state = State.STOPPING if is_moving else State.HALTED
    elif is_moving:
        state = State.MOVING
    mode_after = State.HALTED if halt_reason else State.STANDBY
    cause = Cause(Reason.STOP_TOPIC, halt_reason) if halt_reason else None
    return ControllerMode(state, is_active, mode_after, cause)


def situation(joints, *, is_active=True, is_moving=False, halt_reason="", grasp=None, **measured):
    return Situation(
        measurement=measurement(joints, **measured),
        now=NOW,
        setpoint=np.array(joints),
        mode=mode_of(is_active, is_moving, halt_reason),
        grasp=grasp,
    )
