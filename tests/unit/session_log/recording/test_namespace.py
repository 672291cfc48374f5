# SPDX-License-Identifier: BSD-3-Clause
"""A system in a namespace is recorded by itself, under the names of one without."""

import pytest

from session_log.recording.namespace import Namespace

LEFT, ALONE = Namespace("/left/"), Namespace("/")
NAMES = ("/joint_states", "/rst_control/state", "/left/rst_control/state", "/leftover", "/tf")


@pytest.mark.parametrize("name", NAMES)
def test_without_a_namespace_every_name_stays_and_everything_is_recorded(name):
    assert ALONE.resolved(name) == ALONE.recorded(name) == name
    assert ALONE.has_topic(name) and ALONE.has_node(name)


def test_a_topic_of_the_settings_is_below_the_namespace_unless_all_share_it():
    assert LEFT.resolved("/rst_control/state") == "/left/rst_control/state"
    assert LEFT.resolved("/rosout") == "/rosout"


@pytest.mark.parametrize(
    ("live", "recorded"),
    [("/left/rst_control/state", "/rst_control/state"), ("/rosout", "/rosout"), ("/left", "/left")],
)
def test_a_recording_has_the_names_within_the_namespace(live, recorded):
    assert LEFT.recorded(live) == recorded


@pytest.mark.parametrize(
    ("topic", "is_recorded"),
    [
        *(("/left/joint_states", True), ("/left/a/b", True), ("/diagnostics", True)),
        *(("/right/joint_states", False), ("/joint_states", False), ("/leftover", False)),
    ],
)
def test_topics_of_other_systems_are_left_out(topic, is_recorded):
    assert LEFT.has_topic(topic) is is_recorded


def test_a_node_of_no_namespace_is_none_of_the_system_that_has_one():
    assert LEFT.publisher("/left/controller") == ALONE.publisher("/controller") == "/controller"
    assert LEFT.publisher("/controller") == "/controller of no namespace"
    assert ALONE.publisher("/left/controller") == "/left/controller"


@pytest.mark.parametrize(
    ("node", "is_recorded"),
    [("/left/controller", True), ("/gazebo", True), ("/right/controller", False)],
)
def test_of_a_shared_topic_that_of_other_systems_is_left_out(node, is_recorded):
    assert LEFT.has_node(node) is is_recorded


def test_parameters_are_those_of_the_system_and_the_values_of_all():
    tree = {
        "rosdistro": "noetic",
        "robot_description": "<robot/>",
        "controller": {"rate": 1},
        "left": {"controller": {"rate": 2}, "robot_description": "<left/>"},
    }
    assert LEFT.parameters(tree) == {"rosdistro": "noetic", **tree["left"]}
    assert Namespace("/right/").parameters(tree) == {"rosdistro": "noetic"}
    assert ALONE.parameters(tree) == tree


def test_a_value_in_place_of_a_namespace_is_none():
    assert LEFT.parameters({"left": 3, "rosdistro": "noetic"}) == {"left": 3, "rosdistro": "noetic"}


def test_folders_that_are_named_by_the_time_say_whose_session_it_is():
    assert (ALONE.suffix, LEFT.suffix, Namespace("/room/left/").suffix) == (
        "",
        "_left",
        "_room_left",
    )
