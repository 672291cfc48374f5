# SPDX-License-Identifier: BSD-3-Clause
"""A pull whose tension is not yet confirmed waits where it may go no further, then goes on."""

from dataclasses import replace

import numpy as np
import pytest

from rst_control.config import load_motion_config
from rst_control.execution.guarded_pull import GuardedPull
from rst_control.execution.phase_execution import PhaseStart, TensionPhase
from rst_control.planning.plan import Phase, PhaseKind
from rst_control.tension.grasp_response import GraspResponse
from rst_control.trajectory.motion_profile import MotionBounds
from rst_control.trajectory.path import Path
from rst_control.types import Measurement, PathState

PERIOD = 0.002  # [s]
LENGTH = 0.03  # [m]
STIFFNESS = 60.0  # [N/m]
BOUNDS = MotionBounds(0.02, 0.8, 80.0)
TENSION = replace(load_motion_config().controller.tension, delay=0.085, noise=0.02, bandwidth=3.0)
ALLOWED = TENSION.limit / TENSION.blind_stiffness  # [m] before a reading at rest


@pytest.mark.parametrize("kind", [TensionPhase, GuardedPull])
@pytest.mark.parametrize("between", [0.002, 0.025])  # [s] from one reading to the next
def test_it_rests_where_a_reading_must_confirm_it_and_goes_on(kind, between):
    knots = np.zeros((4, 9))
    knots[:, 0] = np.linspace(0.0, LENGTH, 4)
    path = Path(knots, np.tile([1.0, *[0.0] * 8], (4, 1)), LENGTH)
    phase = Phase(PhaseKind.PULL, path, target=LENGTH, speed=0.02, tension=1.0)
    response = GraspResponse(TENSION, 0.2)
    start = PhaseStart(phase, path, PathState(0.0), 0.0, BOUNDS, BOUNDS)
    pull = kind(start, TENSION, response)
    places = [0.0] * round(TENSION.delay / PERIOD)
    reading = measured(0.0, 0.0)
    for tick in range(round(30.0 / PERIOD)):
        places.append(pull.state.s)
        tension = STIFFNESS * places.pop(0)
        if tick % round(between / PERIOD) == 0:
            reading = measured(tick * PERIOD, tension)
            response.update(reading.stamp, pull.state.s, reading.tension)
            if response.room < np.inf:
                assert pull.state.s <= ALLOWED + 1e-6
        pull.step(PERIOD, reading)
        if pull.is_done:
            break
    assert pull.is_done
    assert pull.failure is None
    assert STIFFNESS * pull.state.s == pytest.approx(1.0, abs=2.0 * TENSION.tolerance)


def measured(stamp, tension):
    still = np.zeros(10)
    return Measurement(still, still, still, stamp, np.array([0.0, 0.0, -tension]), gripped=True)
