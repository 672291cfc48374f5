# SPDX-License-Identifier: BSD-3-Clause
"""The viewer says when no node reports alarms; the node's log separates tones from answers."""

from types import SimpleNamespace

import pytest
import rospy
from diagnostic_msgs.msg import DiagnosticArray

from typed_config import load_yaml
from voice_assist.alarms.board import Standing
from voice_assist.alarms.presenter import latch_alarm
from voice_assist.alarms.screen import NO_WORD
from voice_assist.alarms.types import Kind
from voice_assist.config import CONFIG_DIR
from voice_assist.msg import Alarm
from voice_assist.ros.alarms import messages
from voice_assist.ros.alarms import node as alarm_node
from voice_assist.ros.alarms import viewer as viewer_module
from voice_assist.ros.alarms.viewer import Lines, Viewer


class View:
    """Keeps what it is given."""

    def __init__(self):
        self.seen = []

    def show(self, alarm, is_acknowledged, others):
        self.seen.append("well" if alarm is None else alarm.cause)

    def lose(self):
        self.seen.append("lost")


@pytest.fixture
def links(monkeypatch):
    """Connections of the viewer's topic."""
    links = []
    topic = SimpleNamespace(impl=SimpleNamespace(connections=links))
    known = SimpleNamespace(hear=lambda *_: topic)
    monkeypatch.setattr(viewer_module, "Believed", lambda: known)
    return links


def test_without_an_alarm_node_the_viewer_knows_nothing(links):
    view = View()
    viewer = Viewer(view)
    for _ in range(3):
        viewer.look()
    assert view.seen == ["lost"]  # said once


def test_an_alarm_node_that_died_is_noticed_and_one_that_is_back_counts(links):
    view = View()
    viewer = Viewer(view)
    links.append(SimpleNamespace(socket=object()))
    viewer.look()
    assert view.seen == ["lost"]  # nothing was said yet
    viewer._take(Alarm())
    viewer.look()
    links[0].socket = None  # as rospy leaves the connection to a killed node
    viewer.look()
    viewer.look()
    links.append(SimpleNamespace(socket=object()))
    viewer.look()
    viewer._take(Alarm(kind=Kind.STOP.value, priority=2, cause="stopped by voice"))
    viewer.look()
    assert view.seen == ["lost", "well", "lost", "stopped by voice"]


def test_an_alarm_node_that_hangs_is_noticed_and_so_is_its_next_word(links):
    view, now = View(), [0.0]
    viewer = Viewer(view, lambda: now[0])
    links.append(SimpleNamespace(socket=object()))
    viewer._take(Alarm())
    for now[0] in (1.0, 2.0, 3.0):
        viewer._see_status(DiagnosticArray())
        viewer.look()
    assert view.seen == ["well"]
    now[0] += 4.0
    viewer.look()
    viewer.look()
    assert view.seen == ["well", "lost"]
    viewer._see_status(DiagnosticArray())
    viewer.look()
    assert view.seen == ["well", "lost", "well"]


def test_lines_distinguish_no_alarm_from_no_word(capsys):
    lines = Lines()
    lines.lose()
    lines.show(None, False, ("one more",))
    assert capsys.readouterr().out.splitlines() == [NO_WORD, "no alarm; one more"]


def test_the_log_of_a_missing_answer_claims_nothing_of_the_tones(logged):
    alarm_node._say_sound("no device")
    alarm_node._say_sound("")
    alarm_node._say_unspoken("no answer is spoken: espeak-ng is missing")
    assert logged == [
        "alarms are seen, not heard: no device",
        "alarms are heard again",
        "no answer is spoken: espeak-ng is missing",
    ]


@pytest.mark.parametrize(
    ("file", "phrase", "asked"),
    [
        (None, "hey robot", "ready"),
        ("commands.yaml", "hey robot", "ready"),
        ("commands_de.yaml", "hallo roboter", "unsure, say again"),
    ],
)
def test_the_board_knows_what_can_be_said_also_without_the_parameter(
    monkeypatch, file, phrase, asked
):
    given = load_yaml(CONFIG_DIR / file) if file else None
    monkeypatch.setattr(rospy, "get_param", lambda name, default: given or default)
    boards = []

    def board(config, wakes, ask):
        boards.append((wakes, ask(phrase)))
        raise LookupError  # the rest of the node needs ROS

    monkeypatch.setattr(alarm_node, "Board", board)
    with pytest.raises(LookupError):
        alarm_node.AlarmNode(SimpleNamespace(board=None), alarm_node._load_commands())
    assert boards == [({phrase}, asked)]


def test_answers_have_a_log_of_their_own(monkeypatch):
    made = []
    node = object.__new__(alarm_node.AlarmNode)
    node._config = SimpleNamespace(
        sound=SimpleNamespace(is_enabled=True), speech=SimpleNamespace(quiet_after_stop=1.0)
    )
    node._output, node._answers = object(), object()
    monkeypatch.setattr(alarm_node, "Player", lambda *parts: made.append(parts))
    node._make_player(SimpleNamespace(enter_context=lambda one: one))
    assert alarm_node._say_sound in made[0] and alarm_node._say_unspoken in made[0]


def test_alarms_go_by_a_clock_that_nobody_sets(monkeypatch):
    before = alarm_node._now()
    monkeypatch.setattr(rospy, "get_time", lambda: -600.0)
    assert 0.0 <= alarm_node._now() - before < 60.0


def test_since_when_an_alarm_stands_is_given_by_the_clock_of_messages():
    standing = Standing("latch", latch_alarm("stopped", "stopped", False), since=30.0)
    message = messages.alarm_message([standing], now=42.0, stamp=1000.0)
    assert message.header.stamp.to_sec() == 1000.0
    assert message.since.to_sec() == 988.0
