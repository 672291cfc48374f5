# SPDX-License-Identifier: BSD-3-Clause
"""The tips of the jaws by the compiled chain, against PyBullet's own kinematics."""

import numpy as np
import pytest

from bench.motion.bullet.robot import BulletRobot
from rst_control.config import URDF_FILE, load_simulation_config
from rst_control.kinematics.configuration import robot_joints
from rst_control.kinematics.robot_model import load_robot, parse_robot
from rst_control.simulation.jaw_tips import JawTips
from tests.unit.rst_control.support.renamed_links import renamed_urdf

TIPS = JawTips(load_robot())
SCENE = load_simulation_config().scene
HOME = robot_joints(np.array(SCENE.home), SCENE.home_opening)
FRAME = """<link name="frame" />
  <joint name="joint_frame" type="fixed">
    <origin xyz="0 -0.0025 0" rpy="0 0 0" />
    <parent link="pitch_link" />
    <child link="frame" />
  </joint>
</robot>"""  # on which both fingers hang, 2.5 mm past the pitch link
FINGER_ON_FRAME = '<parent link="frame" />\n    <child link="finger'


@pytest.fixture(scope="module")
def robot():
    with BulletRobot() as robot:
        yield robot


def test_they_are_where_pybullet_has_them_to_a_tenth_of_a_micrometre(robot):
    length = np.array(load_robot().links["tool_tip"].xyz)  # PyBullet says places in 32 bits only
    rng = np.random.default_rng(11)
    for joints in HOME + rng.uniform(-0.7, 0.7, (300, 10)):
        robot.place(joints)
        *fingers, tip = robot.poses(["finger_left_link", "finger_right_link", "tool_tip"])
        expected = np.array([T[:, 3] + T[:, :3] @ length for T in fingers])
        points = TIPS(joints)
        assert np.abs(points[:2] - expected).max() < 1e-7
        assert np.allclose(points[0], tip[:, 3], atol=1e-7)
        assert np.allclose(points[2], expected.mean(axis=0), atol=1e-7)


def test_each_jaw_moves_its_own_tip_only():
    joints = np.linspace(-0.5, 0.5, 10)
    before = TIPS(joints)
    joints[9] += 0.1
    after = TIPS(joints)
    assert np.array_equal(before[0], after[0])
    assert np.linalg.norm(after[1] - before[1]) > 5e-4


def test_a_frame_between_the_pitch_link_and_the_fingers_carries_both():
    text = URDF_FILE.read_text(encoding="utf-8").replace("</robot>", FRAME)
    text = text.replace('"0 -0.0115 0"', '"0 -0.009 0"')
    text = text.replace('<parent link="pitch_link" />\n    <child link="finger', FINGER_ON_FRAME)
    tips = JawTips(parse_robot(text))
    assert text.count(FINGER_ON_FRAME) == 2
    for joints in HOME + np.random.default_rng(12).uniform(-0.7, 0.7, (20, 10)):
        assert np.allclose(tips(joints), TIPS(joints), atol=1e-12)


def test_the_fingers_links_have_any_name():
    tips = JawTips(parse_robot(renamed_urdf()))
    assert np.array_equal(tips(HOME), TIPS(HOME))
