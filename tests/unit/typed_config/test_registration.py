# SPDX-License-Identifier: BSD-3-Clause
"""A node that the master does not know is registered with it again, after a while."""

from types import SimpleNamespace

import pytest
import rospy

from typed_config.ros import registration

OWN, ANOTHER = "http://host:1/", "http://host:2/"
REGISTERED = [
    ("/dead_man", "std_msgs/Bool", "pub"),
    ("/joy", "sensor_msgs/Joy", "sub"),
    ("/mute", "rosrpc://host:3", "srv"),
]


@pytest.fixture
def look(monkeypatch):
    """Lets a node look at a master, by its answer at each second, and gives what it registers."""
    topics = SimpleNamespace(
        get_publications=lambda: [REGISTERED[0][:2]],
        get_subscriptions=lambda: [REGISTERED[1][:2]],
    )
    services = SimpleNamespace(get_services=lambda: [REGISTERED[2][:2]])
    monkeypatch.setattr(registration, "get_topic_manager", lambda: topics)
    monkeypatch.setattr(registration, "get_service_manager", lambda: services)
    monkeypatch.setattr(rospy, "get_name", lambda: "/pedal")
    monkeypatch.setattr(rospy, "logerr", lambda *_: None)
    monkeypatch.setattr(rospy.rostime, "wallsleep", lambda _: None)

    def look(*answers):
        left, made = list(answers), []
        listeners = SimpleNamespace(notify_added=lambda *what: made.append(what))
        monkeypatch.setattr(registration, "get_registration_listeners", lambda: listeners)
        clock = SimpleNamespace(monotonic=lambda: float(len(answers) - len(left)))
        monkeypatch.setattr(registration, "time", clock)
        monkeypatch.setattr(rospy, "is_shutdown", lambda: not left)

        def ask(_, method, own, name):
            assert (method, own, name) == ("lookupNode", "/pedal", "/pedal")
            answer = left.pop(0)
            if isinstance(answer, Exception):
                raise answer
            return answer

        monkeypatch.setattr(registration, "ask", ask)
        registration._stay_registered()
        return made

    return look


UNKNOWN, AWAY = ValueError("unknown node"), ConnectionRefusedError()


def test_a_node_is_registered_again_once_a_master_was_there_for_a_while_without_it(look):
    assert look(OWN, *[UNKNOWN] * 10) == []
    assert look(OWN, *[UNKNOWN] * 11, OWN) == REGISTERED


@pytest.mark.parametrize("answer", [OWN, ANOTHER, AWAY, TimeoutError()])
def test_a_node_is_not_registered_again_where_it_is_known_or_nobody_answers(look, answer):
    assert look(OWN, *[answer] * 100) == []


def test_a_master_that_comes_back_has_time_to_be_given_what_it_knew(look):
    assert look(OWN, *[AWAY] * 100, *[UNKNOWN] * 8, OWN) == []
