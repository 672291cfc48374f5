# SPDX-License-Identifier: BSD-3-Clause
"""The start of a pull along a straight path, and what is measured of held tissue."""

import numpy as np

from rst_control.execution.phase_execution import PhaseStart
from rst_control.planning.plan import Phase, PhaseKind
from rst_control.trajectory.motion_profile import MotionBounds
from rst_control.trajectory.path import Path
from rst_control.types import Measurement, PathState

PERIOD = 0.002  # [s]
LENGTH = 0.03  # [m]
BOUNDS = MotionBounds(0.02, 0.8, 80.0)


def start_of(tension, s=0.0, kind=PhaseKind.PULL):
    """Of a phase that pulls to a tension [N], from a place on its path [m]."""
    knots = np.zeros((4, 9))
    knots[:, 0] = np.linspace(0.0, LENGTH, 4)
    path = Path(knots, np.tile([1.0, *[0.0] * 8], (4, 1)), LENGTH)
    phase = Phase(kind, path, target=LENGTH, speed=0.02, tension=tension)
    return PhaseStart(phase, path, PathState(s), 0.0, BOUNDS, BOUNDS)


def measured(stamp, tension, **more):
    """Held tissue at a time [s]."""
    still, force = np.zeros(10), np.array([0.0, 0.0, -tension])
    return Measurement(still, still, still, stamp, force, gripped=True, **more)
