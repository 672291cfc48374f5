# SPDX-License-Identifier: BSD-3-Clause
"""A tension over its limit on the way to the tissue: it brakes, though no pull has begun."""

from dataclasses import replace

import numpy as np
import pytest

from rst_control.types import Reason, State
from tests.unit.rst_control.support.executor_rig import Rig


def press(rig, rate=8.0):
    """Let the sensor read a force that rises from now on by so much [N/s], and may be true."""
    measured_js, start = rig.robot.measured_js, rig.now

    def pressed():
        true = measured_js()
        return replace(true, force=np.array([0.0, 0.0, -rate * (true.stamp - start)]))

    rig.robot.measured_js = pressed


@pytest.mark.parametrize("phase", ["reach", "close"])
def test_a_tension_over_its_limit_brakes_before_anything_is_pulled(phase):
    rig = Rig().moving(phase)
    press(rig)
    rig.until(lambda: rig.state is not State.MOVING, limit=0.5)
    rig.rest()
    assert rig.state is State.FAULTED
    assert rig.view.mode.cause.reason is Reason.OVER_TENSION


def test_a_tension_that_passes_its_limit_as_the_way_to_tissue_is_broken_off_is_named():
    rig = Rig().moving("reach")
    press(rig)
    rig.until(lambda: rig.view.tension > 2.3, limit=0.5)
    rig.stop()
    rig.rest()
    assert rig.state is State.FAULTED
    assert rig.view.mode.cause.reason is Reason.OVER_TENSION
