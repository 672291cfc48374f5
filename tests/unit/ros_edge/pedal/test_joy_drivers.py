# SPDX-License-Identifier: BSD-3-Clause
"""Pedals on the topic `joy`: whose news count, and what the loss of a driver releases."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
from diagnostic_msgs.msg import DiagnosticStatus

from tests.unit.ros_edge.pedal.bare_pedal import HELD, JOYS, Driven, connection
from voice_assist.pedal.pedals import Brake, Send
from voice_assist.ros.pedal import node as pedal_node


def test_a_driver_that_is_killed_releases_the_dead_man_beside_another(monkeypatch):
    driven = Driven(monkeypatch, "/joy_node", "/joy", "/rosbag_play")
    driven.press("/joy_node")
    driven.lose("/joy")  # it set nothing
    assert driven.check()
    driven.lose("/joy_node")
    assert not driven.check()
    assert "/joy_node publishes joy no more" in driven.actions[0].why
    assert driven.node._state_of_device()[0] == DiagnosticStatus.ERROR


def test_a_driver_whose_connection_broke_counts_as_killed(monkeypatch):
    driven = Driven(monkeypatch, "/joy_node", "/joy")
    driven.press("/joy_node")
    driven.connections[0].socket = None  # rospy would connect anew
    assert not driven.check()


def test_each_input_is_held_by_the_driver_that_set_it_last(monkeypatch):
    driven = Driven(monkeypatch, "/joy_node", "/joy")
    driven.press("/joy_node")
    driven.step("/joy", axes=[1.0])  # it has no such button
    assert driven.check()
    driven.lose("/joy_node")
    assert not driven.check()


def test_a_driver_that_set_everything_anew_outlives_another(monkeypatch):
    driven = Driven(monkeypatch, "/joy_node", "/joy")
    driven.press("/joy_node")
    driven.step("/joy", 1)
    driven.lose("/joy_node")
    assert driven.check()
    driven.lose("/joy")
    assert not driven.check()


def test_a_driver_that_is_back_presses_after_a_release(monkeypatch):
    driven = Driven(monkeypatch, "/joy_node", "/joy")
    driven.step("/joy_node", 0)
    driven.lose("/joy_node")
    assert not driven.check()
    driven.connections.append(connection("/joy_node"))
    for value, is_held in ((1, False), (0, False), (1, True)):
        driven.step("/joy_node", value)
        assert driven.check() is is_held


@pytest.mark.parametrize(
    ("publishers", "trouble", "is_well"),
    [
        ((), pedal_node.NOT_FOUND, False),
        (("/joy",), pedal_node.NOT_FOUND, True),
        (("/rosbag_play",), pedal_node.NOT_FOUND, False),
        (("/joy",), "silent", False),
    ],
)
def test_a_joy_that_sends_changes_only_is_there_once_it_is_connected(
    monkeypatch, publishers, trouble, is_well
):
    node = Driven(monkeypatch, *publishers).node
    node._trouble = trouble
    level, words = node._state_of_device()
    assert (level == DiagnosticStatus.OK) is is_well
    assert is_well or words == trouble


def test_a_connection_that_closed_is_none(monkeypatch):
    driven = Driven(monkeypatch, "/joy")
    driven.node._trouble = pedal_node.NOT_FOUND
    driven.lose("/joy")
    assert driven.node._state_of_device() == (DiagnosticStatus.ERROR, pedal_node.NOT_FOUND)


# Two drivers on one topic: one of them rests, and repeats that nothing is pressed.

A, B = JOYS
RELEASED = Brake("the dead-man (button 0) is released")


class Two(Driven):
    """Drivers A and B by a clock of which a test says how it goes on."""

    def __init__(self, monkeypatch, bound, silent_after=0.0):
        super().__init__(monkeypatch, A, B, bound=bound)
        self.now, node = 0.0, self.node
        monkeypatch.setattr(pedal_node, "time", SimpleNamespace(monotonic=lambda: self.now))
        monkeypatch.setattr(node._pedals, "_clock", lambda: self.now)
        node._config = replace(node._config, silent_after=silent_after)

    def alternate(self, *steps):
        for name, value in steps:
            self.now += 0.1
            self.step(name, value)


@pytest.mark.parametrize(("command", "sent"), [("pull more", 1), ("stop", 21)])
def test_a_press_beside_a_driver_at_rest_is_sent_once_and_a_stop_at_least(
    monkeypatch, command, sent
):
    bound = {**HELD, "does": "command", "command": command}
    driven = Two(monkeypatch, bound)
    driven.alternate((A, 0), (B, 0), (A, 1), *[(B, 0), (A, 1)] * 20)
    assert driven.actions == [Send(command, "button 0")] * sent
    driven.alternate((A, 0), (B, 0), (A, 1))
    assert driven.actions == [Send(command, "button 0")] * (sent + 1)


def test_a_dead_man_is_held_beside_a_driver_at_rest_until_its_own_release(monkeypatch):
    driven = Two(monkeypatch, HELD)
    driven.alternate((A, 0), (B, 0), (A, 1), *[(B, 0), (A, 1)] * 20, (B, 0))
    assert driven.actions == [] and driven.check()
    driven.alternate((A, 0))
    assert driven.actions == [RELEASED] and not driven.check()


def test_after_the_loss_of_the_driver_that_presses_the_news_of_another_release(monkeypatch):
    driven = Two(monkeypatch, HELD)
    driven.alternate((A, 0), (A, 1), (B, 0))
    driven.lose(A)
    driven.alternate((B, 0))
    assert driven.actions == [RELEASED] and not driven.check()


def test_the_loss_of_the_driver_that_presses_brakes_though_the_other_says_nothing(monkeypatch):
    driven = Two(monkeypatch, HELD)
    driven.alternate((A, 0), (A, 1), (B, 0))
    driven.lose(A)
    assert not driven.check() and len(driven.actions) == 1


@pytest.mark.parametrize("says", [[0], []])
def test_a_driver_that_falls_silent_while_it_presses_brakes_beside_another(monkeypatch, says):
    """The other repeats its rest, or has no such button."""
    driven = Two(monkeypatch, HELD, silent_after=0.5)
    driven.alternate((A, 0), (A, 1))
    for _ in range(4):
        driven.now += 0.1
        driven.step(B, *says)
        assert driven.check()
    driven.now += 0.2
    driven.step(B, *says)
    assert not driven.check() and len(driven.actions) == 1
