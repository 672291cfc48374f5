# SPDX-License-Identifier: BSD-3-Clause
"""What the set-point becomes when the measured joints are taken over."""

from __future__ import annotations

import numpy as np
import pytest

from rst_control.configuration import planning_joints, robot_joints
from rst_control.motion import MotionMaker
from rst_control.mover import Mover
from rst_control.types import Measurement


@pytest.mark.parametrize(("gripped", "opening"), [(False, 0.1), (True, 0.0)])
def test_only_jaws_that_hold_tissue_are_sent_to_close_where_it_keeps_them_open(
    motion_config, home, gripped, opening
):
    mover, still = Mover(MotionMaker(motion_config.controller)), np.zeros(10)
    kept_open = robot_joints(home, 0.1)
    mover.synchronise(Measurement(kept_open, still, still, 1.0, gripped=gripped))
    q, sent = planning_joints(mover.held)
    np.testing.assert_allclose(q, home, atol=1e-12)
    assert sent == pytest.approx(opening)


def test_wide_open_jaws_are_not_sent_to_close_whatever_a_sensor_says(motion_config, home):
    mover, still = Mover(MotionMaker(motion_config.controller)), np.zeros(10)
    wide = robot_joints(home, 0.4)
    mover.synchronise(Measurement(wide, still, still, 1.0, gripped=True))
    np.testing.assert_array_equal(mover.held, wide)
