# SPDX-License-Identifier: BSD-3-Clause
from dataclasses import replace

import numpy as np
import pytest

from rst_control.config import URDF_FILE
from rst_control.errors import JointLimitExceeded, RobotModelError
from rst_control.kinematics.joint_limits import make_limits, require_lacking_at_zero, require_ranges
from rst_control.kinematics.robot_model import parse_robot
from rst_control.planning.planner import Planner
from tests.property.six_joints import example
from tests.support.changed_settings import changed
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


def narrower(lower, upper, by):
    """The robot with a range of its URDF narrower by an angle [rad] at its upper end."""
    text = URDF_FILE.read_text(encoding="utf-8")
    old = f'lower="{lower}" upper="{upper}"'
    assert old in text
    return parse_robot(text.replace(old, f'lower="{lower}" upper="{upper - by:.6f}"'))


def test_the_limits_of_the_shipped_robots_are_within_the_ranges_of_their_urdf(robot, motion_config):
    require_ranges(motion_config.limits, robot)
    config, model = example()
    require_ranges(config.limits, model)


@pytest.mark.parametrize(
    ("lower", "upper", "by", "words"),
    [
        ("-2.57", 2.57, 0.3, "limits of joint_4 from -2.57 to 2.57 rad, .* -2.57 to 2.27 rad"),
        ("-2.57", 2.57, 0.002, "limits of joint_4 .* -2.57 to 2.568 rad"),
        ("-1.570796", 1.570796, 0.1, "joint_pitch from -1.5 to 1.5 rad, .* to 1.4708 rad"),
        ("-1.570796", 1.570796, 0.05, "joint_finger_left from -1.5707 to 1.5707 .* to 1.5208 rad"),
    ],
)
def test_limits_beyond_a_range_of_the_urdf_make_no_planner(motion_config, lower, upper, by, words):
    with pytest.raises(RobotModelError, match=words):
        Planner(narrower(lower, upper, by), motion_config)


def test_limits_may_be_beyond_a_range_by_what_is_rounded(motion_config):
    require_ranges(motion_config.limits, narrower("-2.57", 2.57, 0.0009))


def test_home_has_a_joint_that_the_arm_lacks_at_zero():
    config, model = example()
    for angle, is_allowed in ((0.0, True), (5e-10, True), (2e-9, False), (-1.68, False)):
        home = tuple(np.where(np.arange(9) == 6, angle, config.scene.home).tolist())
        if is_allowed:
            Planner(model, changed(config, scene={"home": home}))
            continue
        words = rf"scene.home of joint_7 is {angle:g}, allowed: 0, since the arm lacks it"
        with pytest.raises(ConfigError, match=words):
            Planner(model, changed(config, scene={"home": home}))


def test_home_may_have_a_joint_that_the_arm_has_anywhere(robot, motion_config):
    assert motion_config.scene.home[6] != 0.0
    require_lacking_at_zero("scene.home", motion_config.scene.home, robot)


def test_limits_leave_a_joint_that_the_arm_lacks_no_room_but_for_the_margin():
    config, model = example()
    assert make_limits(config.limits, 0.0).upper[6] == pytest.approx(1e-4)
    for lower, upper in ((-0.0201, 0.03), (-6.2831, 0.0201)):
        ends = {
            "arm_lower": (*config.limits.arm_lower[:6], lower),
            "arm_upper": (*config.limits.arm_upper[:6], upper),
        }
        words = rf"joint_7 from {lower:g} to {upper:g} rad, .* arm lacks, -0.02 to 0.02 rad"
        with pytest.raises(RobotModelError, match=words):
            Planner(model, changed(config, limits=ends))
