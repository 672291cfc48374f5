# SPDX-License-Identifier: BSD-3-Clause
"""Situations for verification, from a few words."""

from __future__ import annotations

import numpy as np

from rst_control.planning.plan import Situation
from rst_control.types import Measurement

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


def situation(joints, *, is_active=True, is_moving=False, halt_reason="", grasp=None, **measured):
    return Situation(
        measurement=measurement(joints, **measured),
        now=NOW,
        setpoint=np.array(joints),
        is_active=is_active,
        is_moving=is_moving,
        halt_reason=halt_reason,
        grasp=grasp,
    )
