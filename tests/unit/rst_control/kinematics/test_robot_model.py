# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest

from rst_control.config import URDF_FILE
from rst_control.errors import RobotModelError
from rst_control.kinematics import forward
from rst_control.kinematics.configuration import Configuration
from rst_control.kinematics.robot_model import load_robot, parse_robot
from support.kdl_chain import kdl_chain
from tests.property.six_joints import URDF


def test_the_route_to_the_tool_tip_passes_all_links_of_arm_and_tool(robot):
    route = robot.route("tool_tip")
    assert route[0] == "shoulder_link"
    assert route[-4:] == ("interface_link", "pitch_link", "finger_left_link", "tool_tip")
    assert len(route) == 12


def test_at_zero_the_arm_stands_upright(robot):
    T = Configuration(robot, np.zeros(9)).frames[forward.TOOL0]
    assert T[2, 3] == pytest.approx(1.18738, abs=1e-4)
    np.testing.assert_allclose(T[:3, 2], [0.0, 0.0, 1.0], atol=1e-12)


def test_the_kdl_chain_has_a_joint_for_each_that_moves(robot):
    assert kdl_chain(robot, "tool_tip").getNrOfJoints() == 9
    assert kdl_chain(robot, "tool0").getNrOfJoints() == 7


def test_the_chain_cannot_be_changed(robot):
    with pytest.raises(ValueError, match="read-only"):
        robot.chain[0, 0, 0] = 2.0


def test_the_same_file_is_read_once():
    assert load_robot(URDF_FILE) is load_robot(URDF_FILE)


def test_an_unknown_link_is_refused(robot):
    with pytest.raises(RobotModelError, match="no link 'elbow'"):
        robot.route("elbow")


def test_a_configuration_is_frozen_and_copied(robot):
    q = np.zeros(9)
    configuration = Configuration(robot, q)
    q[0] = 1.0
    assert configuration.q[0] == 0.0
    for array in (configuration.q, configuration.frames, configuration.J_tip):
        assert not array.flags.writeable


def test_a_configuration_refuses_what_is_not_nine_numbers(robot):
    for bad in (np.zeros(10), np.full(9, np.nan)):
        with pytest.raises(ValueError, match="array"):
            Configuration(robot, bad)


def test_the_yaw_turns_the_tip_but_not_the_shaft(robot, home):
    turned = home + 0.3 * np.eye(9)[8]
    before, after = Configuration(robot, home), Configuration(robot, turned)
    np.testing.assert_array_equal(before.T_base_shaft, after.T_base_shaft)
    assert np.linalg.norm(before.tip - after.tip) == pytest.approx(2 * 0.015 * np.sin(0.15))


@pytest.mark.parametrize(("file", "length"), [(URDF_FILE, 0.28), (URDF, 0.36)])
def test_a_straight_tool_has_its_tip_on_the_shaft_and_its_jaws_along_it(file, length):
    there = Configuration(load_robot(file), np.zeros(9))
    T = np.linalg.inv(there.T_base_shaft) @ there.T_base_tip
    np.testing.assert_allclose(T[:3, 3], [0.0, 0.0, length + 0.0265], atol=1e-12)
    np.testing.assert_allclose(-T[:3, 1], [0.0, 0.0, 1.0], atol=1e-12)


def moved_tip(x):
    text = URDF_FILE.read_text(encoding="utf-8")
    old = '<origin xyz="0 -0.015 0" rpy="0 0 0" />'
    assert text.count(old) == 1
    return text.replace(old, f'<origin xyz="{x} -0.015 0" rpy="0 0 0" />')


def test_a_tip_beside_the_shaft_is_refused_with_its_place_and_what_is_allowed():
    parse_robot(moved_tip(0.00009))
    words = r"at 0\.110, -?0\.000, 306\.500 mm .*allowed: up to 0\.1 mm .*above 280\.000 mm"
    with pytest.raises(RobotModelError, match=words):
        parse_robot(moved_tip(0.00011))
