# SPDX-License-Identifier: BSD-3-Clause
"""The views that open a recording ask only for what a recording holds."""

import json
import re

import pytest
import yaml

from support.message_classes import ROOT, class_of
from tests.support.recorded_topics import TYPES


@pytest.fixture(scope="module")
def layout():
    return json.loads((ROOT / "urdf/foxglove/session.json").read_text(encoding="utf-8"))


def panels(node):
    return [node] if isinstance(node, str) else panels(node["first"]) + panels(node["second"])


def test_every_panel_has_its_settings_and_its_place(layout):
    assert sorted(panels(layout["layout"])) == sorted(layout["configById"])


def test_every_topic_of_the_layout_is_one_that_is_recorded(layout):
    topics = set(re.findall(r'"(/[a-z_/]+)', json.dumps(layout["configById"])))
    assert topics <= set(TYPES) and "/rst_control/state" in topics


def test_every_plotted_field_exists_in_its_message(layout):
    paths = re.findall(r'"value": "(/[a-z_/]+)\.([a-z_]+)', json.dumps(layout))
    assert len(paths) > 10
    for topic, field in paths:
        assert field in class_of(TYPES[topic]).__slots__


def test_every_topic_of_rviz_is_one_that_is_recorded():
    config = yaml.safe_load((ROOT / "urdf/rviz/session.rviz").read_text(encoding="utf-8"))
    displays = config["Visualization Manager"]["Displays"]
    topics = {d["Marker Topic"]: d["Class"] for d in displays if "Marker Topic" in d}
    assert set(topics) == {
        *("/rst_control/markers", "/rst_control/preview"),
        *("/robot/tissue_markers", "/voice_assist/alarm_marker"),
        "/voice_assist/heard_marker",
    }
    for topic, kind in topics.items():
        assert TYPES[topic] == kind.replace("rviz", "visualization_msgs")


def test_rviz_takes_robot_and_frames_from_what_is_recorded():
    config = yaml.safe_load((ROOT / "urdf/rviz/session.rviz").read_text(encoding="utf-8"))
    manager = config["Visualization Manager"]
    robots = [d for d in manager["Displays"] if d["Class"] == "rviz/RobotModel"]
    assert [d["Robot Description"] for d in robots] == ["robot_description"]
    assert TYPES["/robot_description"] == "std_msgs/String"
    assert manager["Global Options"]["Fixed Frame"] == "base_link"
