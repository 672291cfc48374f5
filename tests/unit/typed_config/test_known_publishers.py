# SPDX-License-Identifier: BSD-3-Clause
"""Messages count by the node that published them, as the master knows it; others are named."""

from types import SimpleNamespace

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from std_msgs.msg import Bool

from typed_config.ros import known_publishers
from typed_config.ros.known_publishers import KnownPublishers

AT = "http://host:{}/"


class FakeSubscriber:
    """A subscriber without a master; connections as rospy keeps them."""

    def __init__(self, topic, kind, callback, **options):
        self.resolved_name, self.callback = topic, callback
        self.impl = SimpleNamespace(connections=[])

    def connect(self, name, port=1, done=False):
        header = {"callerid": name}
        self.impl.connections.append(
            SimpleNamespace(
                callerid_pub=name, done=done, header=header, endpoint_id=AT.format(port)
            )
        )
        return header

    def hear(self, header, value=True):
        message = Bool(value)
        message._connection_header = header
        self.callback(message)


@pytest.fixture
def master(monkeypatch):
    """Ports of the nodes by name; `asked` counts the questions."""
    nodes = {"/robot": 1, "/my_gen3/my_gen3_driver": 1, "asked": 0}

    def ask(uri, method, own, name):
        nodes["asked"] += 1
        return AT.format(nodes[name])

    monkeypatch.setattr(known_publishers, "ask", ask)
    monkeypatch.setattr(known_publishers, "ASK_AGAIN", 0.01)
    return nodes


@pytest.fixture
def known(monkeypatch, master):
    monkeypatch.setattr(known_publishers.rospy, "Subscriber", FakeSubscriber)
    monkeypatch.setattr(known_publishers.rospy, "is_shutdown", lambda: False)
    return KnownPublishers()


@pytest.fixture
def link(known):
    """A subscriber that believes one node; it keeps what is heard."""
    heard = []
    link = known.subscribe("/robot/gripped", Bool, heard.append, ["/robot"])
    link.heard = heard
    return link


def test_only_the_node_that_is_known_is_heard(link):
    for name in ("/rostopic_1_2", "/robot2", "", None, "/player", "/robot"):
        link.hear(link.connect(name), value=name == "/robot")
    assert [m.data for m in link.heard] == [True]


def test_a_message_of_no_connection_is_not_heard(link):
    link.hear({"callerid": "/robot"})
    link.hear(None)
    assert not link.heard


def test_who_claims_the_name_from_elsewhere_is_not_heard_and_is_named(known, link):
    liar, true = link.connect("/robot", port=7), link.connect("/robot", port=1)
    for header in (liar, true, liar):
        link.hear(header, value=header is true)
    assert [m.data for m in link.heard] == [True]
    assert known.strangers() == ["/robot/gripped from /robot (http://host:7/ has not that name)"]


def test_the_master_is_asked_once_for_each_connection(link, master):
    for header in (link.connect("/robot"), link.connect("/robot", port=7)):
        for _ in range(5):
            link.hear(header)
    assert master["asked"] == 2


def test_where_the_name_goes_to_another_node_the_older_one_is_a_stranger(link, master):
    older = link.connect("/robot")
    link.hear(older)
    master["/robot"] = 2
    newer = link.connect("/robot", port=2)
    link.hear(newer, value=False)
    link.hear(older)
    assert [m.data for m in link.heard] == [True, False]


def test_a_master_that_does_not_answer_is_asked_again_and_the_message_waits(link, monkeypatch):
    header = link.connect("/robot")
    answers = [OSError("nobody"), ValueError("unknown node"), AT.format(1)]

    def ask(*_):
        answer = answers.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return answer

    monkeypatch.setattr(known_publishers, "ask", ask)
    link.hear(header)
    assert (answers, len(link.heard)) == ([], 1)


def test_names_may_end_in_a_star_and_none_is_anybody(known):
    heard = []
    link = known.subscribe("/a", Bool, heard.append, ["/my_gen3/*"])
    link.hear(link.connect("/my_gen3/my_gen3_driver"))
    anybody = known.subscribe("/b", Bool, heard.append, [])
    anybody.hear(anybody.connect("/any_node", port=9))
    assert len(heard) == 2


def test_strangers_are_named_as_long_as_they_are_connected(known, link):
    link.connect("/robot")
    status = known.status("rst_control", "controller")
    assert (status.level, status.name) == (DiagnosticStatus.OK, "rst_control: strangers")
    link.connect("/player_7_8")
    link.connect("/gone", done=True)
    status = known.status("rst_control", "controller")
    assert status.level == DiagnosticStatus.ERROR
    assert status.message == "not believed: /robot/gripped from /player_7_8"
    assert [(v.key, v.value) for v in status.values] == [("reason_code", "stranger")]
    link.impl.connections[1].done = True
    assert known.strangers() == []


def test_where_anybody_is_taken_nobody_is_a_stranger(known):
    known.subscribe("/b", Bool, print, []).connect("/any_node")
    assert known.strangers() == []


def test_where_others_publish_rightly_they_are_passed_over_and_not_named(known):
    heard = []
    link = known.subscribe("/diagnostics", Bool, heard.append, ["/robot"])
    link.hear(link.connect("/camera_driver", port=5))
    assert (heard, known.strangers()) == ([], [])


def test_a_topic_on_which_anybody_is_believed_is_warned_of(known):
    known.subscribe("/robot/gripped", Bool, lambda _: None, ["/robot"])
    assert known.status("robot", "controller").level == DiagnosticStatus.OK
    known.subscribe("/gen3/state_command", Bool, lambda _: None, [])
    status = known.status("robot", "controller")
    assert status.level == DiagnosticStatus.WARN
    assert "anybody is believed on /gen3/state_command" in status.message


def test_a_stranger_is_named_before_a_topic_of_anybody(known):
    known.subscribe("/gen3/state_command", Bool, lambda _: None, [])
    known.subscribe("/robot/gripped", Bool, lambda _: None, ["/robot"]).connect("/other", 2)
    status = known.status("robot", "controller")
    assert status.level == DiagnosticStatus.ERROR
    assert "/robot/gripped from /other" in status.message
