# SPDX-License-Identifier: BSD-3-Clause
"""Forward kinematics against PyBullet's own, and the RCM error that follows from it."""

from pathlib import Path

import numpy as np
import pytest

from bench.motion.bullet.robot import BulletRobot
from rst_control.types import JOINTS
from session_log.mcap_file.summary import RecordingSummary
from session_log.report.session.kinematics import ModelUnfit, poses
from session_log.report.session.session_data import (
    RecordedTrocar,
    SampledTable,
    SessionData,
    Span,
)
from session_log.report.session.shaft import is_moving, rcm_from_joints
from support.story_script import TROCAR_CHANGE, URDF, joint_text
from tests.unit.session_log.report.session.test_joint_peaks import MODEL

ROOT = Path(__file__).resolve().parents[5]
REAL = ROOT / "urdf" / "gen3_openrst.urdf"


@pytest.mark.parametrize("link", ["interface_link", "tool_tip", "half_arm_2_link"])
def test_poses_agree_with_pybullet(link):
    joints = np.random.default_rng(3).uniform(-1.5, 1.5, (20, len(JOINTS)))
    q = dict(zip(JOINTS, joints.T, strict=True))
    ours = poses(REAL.read_text(encoding="utf-8"), "base_link", link, q)
    with BulletRobot(REAL) as robot:
        for T, row in zip(ours, joints, strict=True):
            robot.place(row)
            np.testing.assert_allclose(T[:3], robot.poses([link])[0], atol=1e-6)  # of float32


def test_a_sliding_joint_slides_along_its_axis():
    text = f"<robot>{joint_text('s', 'prismatic', 'base', 'tip', 0.5)}</robot>"
    T = poses(text, "base", "tip", {"s": np.array([0.0, 0.2])})
    np.testing.assert_allclose(T[:, :3, 3], [[0, 0, 0.5], [0, 0, 0.7]], atol=1e-12)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("<robot>", "it is no URDF"),
        ("<robot/>", "no joints lead from base to tip"),
        (f"<robot>{joint_text('a', 'planar', 'base', 'tip')}</robot>", "joint a is planar"),
        (f"<robot>{joint_text('b', 'revolute', 'base', 'tip')}</robot>", "joint b is not among"),
        (f"<robot>{joint_text('q', 'fixed', 'base', 'tip', 'x')}</robot>", "three numbers"),
        (f"<robot>{joint_text('q', 'fixed', 'tip', 'tip')}</robot>", "no joints lead"),
    ],
)
def test_a_model_that_does_not_fit_says_why(text, why):
    with pytest.raises(ModelUnfit, match=why):
        poses(text, "base", "tip", {"q": np.zeros(3)})


def test_the_error_is_the_distance_from_the_active_trocar(data, report_config):
    found = rcm_from_joints(data, report_config)
    assert found.lacking == ""
    before, after = found.time < TROCAR_CHANGE, found.time > TROCAR_CHANGE + 0.01
    np.testing.assert_allclose(found.error[before], 5e-6, rtol=1e-6)
    np.testing.assert_allclose(found.error[after], 10e-6, rtol=1e-6)
    assert 0 < len(found.while_moving) < len(found.error)


def tilted(config, trocar, angle, **changes):
    """A session of one joint about x, whose shaft leans by an angle from the z axis."""
    joints = SampledTable(("time", "turn"))
    joints.extend(np.array([0.0]), np.array([angle]))
    parts = {"urdf": MODEL, "joints": joints}
    parts["trocars"] = [RecordedTrocar(5.0, trocar, "base_link")]
    return rcm_from_joints(SessionData(RecordingSummary(None), **{**parts, **changes}), config)


def test_a_leaning_shaft_is_off_by_the_sine_of_its_angle(report_config):
    (error,) = tilted(report_config, (0.0, 0.0, 0.2), 0.01).error
    assert error == pytest.approx(0.2 * np.sin(0.01), rel=1e-9)


def test_there_is_no_error_while_the_tip_is_outside(report_config):
    assert np.isnan(tilted(report_config, (0.0, 0.0, 0.31), 0.01).error).all()
    assert np.isfinite(tilted(report_config, (0.0, 0.0, 0.29), 0.01).error).all()


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"joints": None}, "no joint states"),
        ({"urdf": ""}, "no robot model"),
        ({"urdf": URDF}, "joint joint_1 is not among the recorded joints"),
        ({"trocars": []}, "no trocar"),
        (
            {"trocars": [RecordedTrocar(0.0, (0.0, 0.0, 0.1), "camera")]},
            "given in camera, not in base",
        ),
    ],
)
def test_what_is_lacking_is_named(report_config, changes, why):
    found = tilted(report_config, (0.0, 0.0, 0.2), 0.0, **changes)
    assert why in found.lacking and len(found.error) == 0


def test_times_are_found_at_which_the_robot_moved():
    spans = [
        Span(0.0, 1.0, "active"),
        Span(1.0, 2.0, "moving"),
        Span(2.0, 3.0, "stopping"),
    ]
    time = np.array([0.5, 1.0, 1.9, 2.0, 3.0])
    found = is_moving(time, spans)
    assert found.tolist() == [False, True, True, True, False]
