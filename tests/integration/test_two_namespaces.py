# SPDX-License-Identifier: BSD-3-Clause
"""Two systems in namespaces of one master: each obeys its own words, and is recorded by itself."""

import pytest

from session_log.export.arrays import read_columns
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.summary import read_summary
from support.waiting import wait_until
from tests.support.ros_host import ASK, Host

SIDES = ("left", "right")
QUIET = {"voice": "false", "alarms": "false"}
STATE, URDF = "/rst_control/state", "/robot_description"
RECORDED = (STATE, "/joint_states", "/rst_control/event")
SHARED = {"/rosout", "/diagnostics", "/tf", "/tf_static"}


@pytest.fixture(scope="module")
def sessions(tmp_path_factory):
    """Both recordings, after a "hey robot" on the left."""
    folder = tmp_path_factory.mktemp("two")
    host = Host(folder)
    try:
        host.start_master()
        for side in SIDES:
            host.launch("system", {"ROS_NAMESPACE": side}, sessions=folder, session=side, **QUIET)
        for side in SIDES:
            wait_until(lambda side=side: host.is_found(f"/{side}/rst_control/command"), every=ASK)
        for side in SIDES:  # a recorder finds topics one after the other
            topics = [f"/{side}{topic}" for topic in RECORDED]
            recorder = f"/{side}/recorder"
            wait_until(lambda who=recorder, what=topics: host.hears(who, *what), every=ASK)
        wait_until(lambda: "accepted: True" in host.give("hey robot", "/left"), every=0.5)
        assert "in standby" in host.give("tense", "/right")
    finally:
        host.close()
    return {side: SessionReader(folder / side) for side in SIDES}


def states(reader):
    return set(read_columns(reader, STATE)["state"])


def test_each_recording_has_the_states_of_its_own_system(sessions):
    assert ["active" in states(sessions[side]) for side in SIDES] == [True, False]


@pytest.mark.parametrize("side", SIDES)
def test_a_recording_has_the_names_and_the_nodes_of_its_system_alone(sessions, side):
    topics = {}
    for message in sessions[side].messages():
        topics.setdefault(message.source.topic, set()).add(message.source.publisher)
    assert {*RECORDED, URDF, *SHARED} <= set(topics)
    other = [topic for topic in topics if topic.startswith(("/left", "/right"))]
    names = set().union(*topics.values()) - {"", "/rosout"}
    names = {name for name in names if not name.startswith("/rosservice_")}  # a call by hand
    nodes = {"/controller", "/robot", "/recorder", "/robot_state_publisher", "/master_failover"}
    assert (other, names - nodes) == ([], set())


@pytest.mark.parametrize("side", SIDES)
def test_a_recording_says_its_namespace_and_has_the_settings_of_its_system(sessions, side):
    condition = read_summary(sessions[side]).condition
    assert condition.latest("session")["namespace"] == f"/{side}/"
    parameters = condition.latest("parameters")
    assert {"controller", "recorder", "rosdistro"} <= set(parameters) and not {*SIDES} & {
        *parameters
    }
