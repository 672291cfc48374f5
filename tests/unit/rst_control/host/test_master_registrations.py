# SPDX-License-Identifier: BSD-3-Clause
"""What one ROS master knew is registered with the next."""

from rst_control.host.master_registrations import Registrations, missing_parameters, pairs_of

KNOWN = Registrations(
    publishers=frozenset({("/joint_states", "/robot"), ("/state", "/controller")}),
    subscribers=frozenset({("/joint_states", "/controller")}),
    services=frozenset({("/command", "/controller"), ("/reset", "/robot")}),
    types={"/joint_states": "sensor_msgs/JointState", "/state": "rst_control/ControllerState"},
    nodes={"/robot": "http://127.0.0.1:1", "/controller": "http://127.0.0.1:2"},
    service_uris={"/command": "rosrpc://127.0.0.1:3", "/reset": "rosrpc://127.0.0.1:4"},
)


def test_all_is_registered_publishers_before_subscribers():
    calls = KNOWN.calls()
    methods = [call[0] for call in calls]
    assert methods == ["registerPublisher"] * 2 + ["registerSubscriber"] + ["registerService"] * 2
    assert calls[0] == (
        "registerPublisher",
        "/robot",
        "/joint_states",
        "sensor_msgs/JointState",
        "http://127.0.0.1:1",
    )
    service = ("registerService", "/controller", "/command", "rosrpc://127.0.0.1:3")
    assert (*service, "http://127.0.0.1:2") in calls


def test_the_node_that_shows_that_all_was_done_comes_last():
    calls = KNOWN.calls(last="/controller")
    assert [call[1] for call in calls] == ["/robot"] * 2 + ["/controller"] * 3


def test_what_the_next_one_knows_is_not_registered_again():
    assert KNOWN.without(KNOWN).calls() == []
    present = KNOWN.of({"/robot"})
    assert {call[1] for call in KNOWN.without(present).calls()} == {"/controller"}


def test_who_has_ended_is_left_out():
    calls = KNOWN.of({"/robot"}).calls()
    assert {call[1] for call in calls} == {"/robot"}


def test_what_either_knows_is_joined_with_the_newer_addresses():
    newer = Registrations(nodes={"/robot": "http://127.0.0.1:9"})
    joined = newer.joined(KNOWN)
    assert joined.nodes["/robot"] == "http://127.0.0.1:9"
    assert joined.publishers == KNOWN.publishers


def test_a_topic_of_unknown_type_is_registered_with_any():
    some = Registrations(subscribers=frozenset({("/x", "/n")}), nodes={"/n": "http://h:1"})
    assert some.calls() == [("registerSubscriber", "/n", "/x", "*", "http://h:1")]


def test_a_service_whose_address_was_not_found_is_left_out():
    some = Registrations(services=frozenset({("/x", "/n")}), nodes={"/n": "http://h:1"})
    assert some.calls() == []


def test_the_masters_lists_are_read():
    assert pairs_of([["/x", ["/a", "/b"]], ["/y", []]]) == {("/x", "/a"), ("/x", "/b")}


def test_only_parameters_that_are_missing_are_set():
    known = {"a": 1, "node": {"rate": 5, "deep": {"x": 1, "y": 2}}, "run_id": "old"}
    present = {"run_id": "new", "node": {"rate": 6, "deep": {"x": 3}}}
    assert missing_parameters(known, present) == {"/a": 1, "/node/deep/y": 2}
    assert missing_parameters(known, known) == {}


def test_the_next_master_names_its_run_itself():
    """Roscore sets the name a moment after the master is there, and gives up where it differs."""
    known = {"run_id": "old", "node": {"run_id": 7}}
    assert missing_parameters(known, {}) == {"/node": {"run_id": 7}}
    assert missing_parameters(known, {"node": {}}) == {"/node/run_id": 7}


def test_a_publisher_that_was_started_anew_is_news_though_its_name_is_known():
    assert KNOWN.news(Registrations()) == {"/joint_states", "/state"}
    assert KNOWN.news(KNOWN) == set()
    moved = Registrations(nodes={"/robot": "http://127.0.0.1:9"}).joined(KNOWN)
    assert moved.news(KNOWN) == {"/joint_states"}


def test_subscribers_get_all_publishers_of_their_topics():
    more = Registrations(
        publishers=frozenset({("/joint_states", "/other"), ("/joint_states", "/gone")}),
        subscribers=frozenset({("/state", "/gone")}),
        nodes={"/other": "http://127.0.0.1:7"},
    ).joined(KNOWN)
    uris = ["http://127.0.0.1:7", "http://127.0.0.1:1"]
    assert more.updates({"/joint_states", "/state"}) == {"/controller": {"/joint_states": uris}}
    assert more.updates({"/state"}) == {}
