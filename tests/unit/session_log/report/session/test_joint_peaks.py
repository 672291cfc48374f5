# SPDX-License-Identifier: BSD-3-Clause
"""What happens between two samples of the joint states is in the figures that name an extreme."""

import numpy as np
import pytest

from session_log.report.session.extract import extract
from session_log.report.session.joint_margins import smallest_margin
from session_log.report.session.shaft import rcm_from_joints
from session_log.report.session.summary import summarise
from support.story import Story, recording_of
from support.story_script import joint_text

TILT = 0.01  # [rad] for 12 ms
TROCAR = (0.0, 0.0, 0.2)  # [m]
LEANING = joint_text("turn", "revolute", "base_link", "interface_link", 0.0).replace(
    "xyz='0 0 1'", "xyz='1 0 0'"
)
MODEL = f"<robot>{LEANING}{joint_text('tip', 'fixed', 'interface_link', 'tool_tip', 0.3)}</robot>"


def leaning(names=("turn",), rate=500):
    """A second of motion in which one joint leans for a moment that no sample meets."""
    story = Story()
    story.say(0.0, "/robot_description", "std_msgs/String", data=MODEL)
    story.trocar(0.0, TROCAR)
    for k in range(50):
        fields = {"state": "moving", "phase": "pull"}
        story.say(k / 50, "/rst_control/state", "rst_control/ControllerState", **fields)
    for k in range(rate):
        q = TILT if 251 <= k < 257 else 0.0
        fields = {"name": list(names), "position": [q] * len(names)}
        story.say(k / rate + 1e-4, "/joint_states", "sensor_msgs/JointState", **fields)
    return sorted(story.messages, key=lambda message: message.log_time)


def test_a_lean_between_two_samples_is_the_largest_error_and_the_smallest_margin(
    tmp_path, report_config
):
    data = extract(recording_of(tmp_path / "s.mcap", leaning()), report_config)
    assert len(data.joints) == pytest.approx(50, abs=2) and not data.joints["turn"].any()
    assert smallest_margin(data) == pytest.approx(2.2 - TILT)
    rcm, expected = rcm_from_joints(data, report_config), TROCAR[2] * np.sin(TILT)
    summary = summarise("s", data, [], rcm, report_config)
    assert summary.rcm_joints.largest == pytest.approx(expected)
    assert summary.rcm_joints.rms == 0.0  # of the samples, which are even in time
    time, error = rcm.curve
    assert time[error.argmax()] == pytest.approx(0.502, abs=0.02)


def test_joint_states_that_change_their_names_give_the_extremes_of_each_list(
    tmp_path, report_config
):
    first, second = leaning(), leaning(names=("other",))
    mixed = [b if k % 3 else a for k, (a, b) in enumerate(zip(first, second, strict=True))]
    data = extract(recording_of(tmp_path / "s.mcap", mixed), report_config)
    assert data.joint_ranges == {"turn": (0.0, TILT), "other": (0.0, TILT)}
    assert data.rcm_peaks["error"].max() == pytest.approx(TROCAR[2] * np.sin(TILT))
    assert not data.missing_fields and not data.undecodable


@pytest.mark.parametrize(
    ("names", "position"),
    [([], []), (["other"], [0.5]), (["turn", "other"], [0.0, 0.0]), ([], [0.5]), (["turn"], [])],
)
def test_one_odd_joint_state_hides_no_lean_between_two_samples(
    tmp_path, report_config, names, position
):
    story = Story()
    story.say(0.3, "/joint_states", "sensor_msgs/JointState", name=names, position=position)
    messages = sorted([*leaning(), *story.messages], key=lambda message: message.log_time)
    data = extract(recording_of(tmp_path / "s.mcap", messages), report_config)
    assert smallest_margin(data) == pytest.approx(2.2 - TILT)
    largest = rcm_from_joints(data, report_config).largest
    assert largest == pytest.approx(TROCAR[2] * np.sin(TILT))
    assert not data.missing_fields and not data.undecodable


def test_misfits_of_a_sampled_topic_count_once(tmp_path, report_config):
    odd = [m._replace(data=b"\1") if m.source.topic == "/joint_states" else m for m in leaning()]
    data = extract(recording_of(tmp_path / "s.mcap", odd), report_config)
    assert data.undecodable == {"/joint_states": 500}
