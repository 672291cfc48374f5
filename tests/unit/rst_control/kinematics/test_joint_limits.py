# SPDX-License-Identifier: BSD-3-Clause
from dataclasses import replace

import numpy as np
import pytest

from rst_control.errors import JointLimitExceeded
from rst_control.kinematics.joint_limits import make_limits
from typed_config import ConfigError


def test_limits_lie_inside_the_robots_by_the_margin(motion_config):
    limits = make_limits(motion_config.limits, opening=0.6)
    margin = motion_config.limits.position_margin
    assert limits.upper[3] == pytest.approx(2.57 - margin)
    assert limits.lower[5] == pytest.approx(-2.09 + margin)


def test_wide_jaws_leave_less_yaw(motion_config):
    narrow, wide = (make_limits(motion_config.limits, opening) for opening in (0.0, 0.8))
    assert narrow.upper[8] - wide.upper[8] == pytest.approx(0.4)


def test_the_active_layer_sets_velocity_and_acceleration(motion_config):
    soft = make_limits(replace(motion_config.limits, layer="driver_soft"), 0.0)
    hard = make_limits(replace(motion_config.limits, layer="hard"), 0.0)
    assert soft.velocity[0] == pytest.approx(0.8727)
    assert (soft.acceleration[:4] < hard.acceleration[:4]).all()


def test_a_layer_that_is_not_defined_is_refused_with_those_that_are(motion_config):
    with pytest.raises(ConfigError, match="layer is 'soft', allowed: one of hard, driver_soft"):
        motion_config.limits.named("soft")


def test_the_joint_furthest_outside_is_named_with_its_range(motion_config):
    limits = make_limits(motion_config.limits, 0.0)
    q = np.zeros(9)
    limits.require(q)
    q[1], q[3] = 2.3, 2.9
    with pytest.raises(JointLimitExceeded, match=r"joint_4 at 2\.900 rad, allowed -2\.550 to 2\.5"):
        limits.require(q)
