# SPDX-License-Identifier: BSD-3-Clause
"""What a press does: late news, a controller that does not listen, a stop beside a command."""

import time

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from sensor_msgs.msg import Joy

from tests.unit.ros_edge.pedal.bare_pedal import (
    BRAKED,
    CONTROLLER,
    HELD,
    MORE,
    STOP,
    Acting,
    Driven,
)
from voice_assist.ros.pedal import node as pedal_node


@pytest.mark.parametrize(
    ("age", "is_wallclock", "is_late"),
    [
        (0.0, True, False),
        (0.5, True, False),
        (5.0, True, True),
        (-0.1, True, False),
        (-5.0, True, True),
        (None, True, False),
        (5.0, False, False),
    ],
)
def test_a_late_press_moves_nothing_and_stops_all_the_same(monkeypatch, age, is_wallclock, is_late):
    acting = Acting(monkeypatch, STOP, MORE)
    acting.is_wallclock = is_wallclock
    stamp = 0.0 if age is None else time.time() - age
    acting.node._take({"button 1": 1.0}, stamp)
    assert acting.acts == ([] if is_late else ["pull more"])
    assert ("is dropped" in acting.words[0]) is is_late
    acting.node._take({"button 0": 1.0}, stamp)
    assert acting.acts[-2:] == ["stop is published", "stop"]


def test_a_late_release_of_the_dead_man_brakes(monkeypatch):
    acting = Acting(monkeypatch, HELD)
    acting.node._take({"button 0": 1.0}, time.time())
    acting.node._take({"button 0": 0.0}, time.time() - 60.0)
    assert acting.acts == ["dead-man True", "dead-man False", *BRAKED]


def test_a_dead_man_whose_news_become_late_is_released_until_a_press_in_time(monkeypatch):
    acting = Acting(monkeypatch, HELD)
    acting.node._take({"button 0": 1.0}, time.time())
    for _ in range(3):
        acting.node._take({"button 0": 1.0}, time.time() - 5.0)
    assert acting.acts == ["dead-man True", "dead-man False", *BRAKED]
    level, words = acting.node._state_of_device()
    assert level == DiagnosticStatus.ERROR and "5.00 s old" in words
    assert sum("5.00 s old" in said for said in acting.words) == 2  # the news, and the stop
    acting.acts.clear()
    for value, acts in ((1.0, []), (0.0, []), (1.0, ["dead-man True"])):
        acting.node._take({"button 0": value}, time.time())
        assert acting.acts == acts
    assert acting.node._state_of_device() == (DiagnosticStatus.OK, "there")


def test_a_late_press_holds_no_dead_man_and_stops_nothing(monkeypatch):
    acting = Acting(monkeypatch, HELD)
    acting.node._take({"button 0": 1.0}, time.time() - 5.0)
    assert acting.acts == [] and not acting.node._pedals.is_held


@pytest.mark.parametrize(("does", "opens"), [("talk", 1.0), ("mute", 0.0)])
def test_late_news_open_no_gate(monkeypatch, does, opens):
    acting = Acting(monkeypatch, {**HELD, "does": does})
    acting.node._take({"button 0": 1.0 - opens}, time.time())
    acting.node._take({"button 0": opens}, time.time() - 5.0)
    assert not acting.node._pedals.may_talk
    for value in (1.0 - opens, opens):
        acting.node._take({"button 0": value}, time.time())
    assert acting.node._pedals.may_talk


@pytest.mark.parametrize("at", ["before", "after"])
def test_the_dead_man_is_told_before_a_command_of_the_same_news(monkeypatch, at):
    acting = Acting(monkeypatch, HELD, MORE)
    news = {"button 0": 1.0, "button 1": 1.0}
    acting.node._take(news if at == "before" else dict(reversed(news.items())))
    assert acting.acts == ["dead-man True", "pull more"]


@pytest.mark.parametrize("value", [0.0, 1.0])
def test_each_look_tells_whether_the_dead_man_is_held(monkeypatch, value):
    acting = Acting(monkeypatch, HELD)
    acting.node._take({"button 0": value})
    acting.acts.clear()
    for _ in range(2):
        acting.node._check()
    assert acting.acts == [f"dead-man {bool(value)}"] * 2


def test_a_pedal_without_a_dead_man_tells_of_none(monkeypatch):
    acting = Acting(monkeypatch, STOP, MORE)
    acting.node._check()
    assert acting.acts == []


def test_a_node_that_ends_tells_that_the_dead_man_is_released(monkeypatch):
    acting = Acting(monkeypatch, HELD)
    acting.node._take({"button 0": 1.0})
    acting.acts.clear()
    acting.node._leave()
    assert acting.acts == [*BRAKED, "dead-man False"]


def test_a_joy_has_the_age_of_its_header(monkeypatch):
    acting = Acting(monkeypatch, STOP, MORE)
    acting.node._set_by = {}
    message = Joy(buttons=[0, 1], axes=[])
    message.header.stamp.secs = 5
    acting.node._on_joy(message)
    assert acting.acts == [] and "is dropped" in acting.words[0]
    message.buttons = [1, 1]
    acting.node._on_joy(message)
    assert acting.acts == ["stop is published", "stop"]


# A controller that does not hear the dead-man, such as one of a new master.


@pytest.mark.parametrize("listeners", [set(), {"/recorder"}])
@pytest.mark.parametrize("does", ["dead_man", "talk", "mute"])
def test_a_controller_that_does_not_listen_gets_stops_and_nothing_else(
    monkeypatch, does, listeners
):
    acting = Acting(monkeypatch, {**HELD, "does": does}, MORE, {**STOP, "input": "button 2"})
    acting.listeners, acting.node._tell = listeners, lambda: None
    acting.node._take({"button 1": 1.0, "button 2": 1.0})
    assert acting.acts == BRAKED
    assert "pull more, by button 1, is dropped: the controller does not listen" in acting.words[0]
    level, words = acting.node._state_of_device()
    assert level == DiagnosticStatus.ERROR and "the controller does not listen" in words
    acting.listeners = {CONTROLLER}
    acting.node._take({"button 1": 0.0})
    acting.node._take({"button 1": 1.0})
    assert acting.acts[-1] == "pull more"
    assert acting.node._state_of_device() == (DiagnosticStatus.OK, "there")


def test_a_release_that_the_controller_does_not_hear_stops_by_the_service(monkeypatch):
    acting = Acting(monkeypatch, HELD)
    acting.listeners = set()
    acting.node._take({"button 0": 1.0})
    acting.node._take({"button 0": 0.0})
    assert acting.acts == ["dead-man True", "dead-man False", *BRAKED]


def test_commands_alone_need_nobody_who_hears_a_dead_man(monkeypatch):
    acting = Acting(monkeypatch, STOP, MORE)
    acting.listeners = set()
    acting.node._take({"button 1": 1.0})
    assert acting.acts == ["pull more"]
    assert acting.node._state_of_device() == (DiagnosticStatus.OK, "there")


def test_a_joy_that_is_connected_is_not_well_while_the_controller_does_not_listen(monkeypatch):
    node = Driven(monkeypatch, "/joy").node
    node._trouble = pedal_node.NOT_FOUND
    monkeypatch.setattr(pedal_node, "open_listeners", lambda _: set())
    assert node._state_of_device()[0] == DiagnosticStatus.ERROR


# A stop and another command in one message, or by one foot on two switches of a USB device.

WAKE = {**MORE, "command": "hey robot"}


@pytest.mark.parametrize("order", [("button 0", "button 1"), ("button 1", "button 0")])
def test_a_stop_drops_the_other_commands_of_its_message(monkeypatch, order):
    acting = Acting(monkeypatch, STOP, WAKE)
    acting.node._take(dict.fromkeys(order, 1.0))
    assert acting.acts == BRAKED
    dropped = "pedal: hey robot, by button 1, is dropped: a stop came with it"
    assert acting.words.count(dropped) == 1


def test_a_release_of_the_dead_man_drops_the_commands_of_its_message(monkeypatch):
    acting = Acting(monkeypatch, HELD, WAKE)
    acting.node._take({"button 0": 1.0})
    acting.acts.clear()
    acting.node._take({"button 1": 1.0, "button 0": 0.0})
    assert acting.acts == ["dead-man False", *BRAKED]


@pytest.mark.parametrize(("later", "is_sent"), [(0.005, False), (0.29, False), (0.5, True)])
def test_just_after_a_stop_no_other_command_is_sent(monkeypatch, later, is_sent):
    acting, now = Acting(monkeypatch, STOP, WAKE), [10.0]
    monkeypatch.setattr(acting.node._pedals, "_clock", lambda: now[0])
    acting.node._take({"button 0": 1.0})
    now[0] += later
    acting.node._take({"button 1": 1.0})
    assert acting.acts == [*BRAKED, *["hey robot"] * is_sent]
    assert any("is dropped: a stop came just before it" in w for w in acting.words) is not is_sent
    acting.node._take({"button 0": 0.0})
    acting.node._take({"button 0": 1.0})
    assert acting.acts[-2:] == BRAKED  # a stop is never dropped
