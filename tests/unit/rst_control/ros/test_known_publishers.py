# SPDX-License-Identifier: BSD-3-Clause
"""Messages count by the name of the node that published them; who else does is named."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from std_msgs.msg import Bool

from rst_control.ros.common import known_publishers
from rst_control.ros.common.known_publishers import KnownPublishers


class FakeSubscriber:
    """A subscriber without a master; connections as rospy keeps them."""

    def __init__(self, topic, kind, callback, **options):
        self.resolved_name, self.callback = topic, callback
        self.impl = SimpleNamespace(connections=[])

    def connect(self, name, done=False):
        self.impl.connections.append(SimpleNamespace(callerid_pub=name, done=done))

    def hear(self, name, value=True):
        message = Bool(value)
        message._connection_header = {"callerid": name}
        self.callback(message)


@pytest.fixture
def known(monkeypatch):
    monkeypatch.setattr(known_publishers.rospy, "Subscriber", FakeSubscriber)
    return KnownPublishers()


def test_only_the_node_that_is_known_is_heard(known):
    heard = []
    link = known.subscribe("/robot/gripped", Bool, heard.append, ["/robot"])
    for name in ("/rostopic_1_2", "/robot2", "", None, "/player", "/robot"):
        link.hear(name, value=name == "/robot")
    assert [m.data for m in heard] == [True]


def test_names_may_end_in_a_star_and_none_is_anybody(known):
    heard = []
    known.subscribe("/a", Bool, heard.append, ["/my_gen3/*"]).hear("/my_gen3/my_gen3_driver")
    known.subscribe("/b", Bool, heard.append, []).hear("/whoever")
    assert len(heard) == 2


def test_strangers_are_named_as_long_as_they_are_connected(known):
    link = known.subscribe("/robot/gripped", Bool, print, ["/robot"])
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
    known.subscribe("/b", Bool, print, []).connect("/whoever")
    assert known.strangers() == []
