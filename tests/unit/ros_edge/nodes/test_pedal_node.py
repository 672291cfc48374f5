# SPDX-License-Identifier: BSD-3-Clause
"""A pedal that can no longer be read counts as released; what is said of one that sent nothing."""

import threading
from types import SimpleNamespace

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from sensor_msgs.msg import Joy

from typed_config import load_yaml
from voice_assist.config import CONFIG_DIR
from voice_assist.config.pedal import pedal_config
from voice_assist.pedal.pedals import Brake, Pedals
from voice_assist.ros.pedal import node as pedal_node
from voice_assist.ros.pedal.node import PedalNode

HELD = {"input": "button 0", "above": 0.5, "does": "dead_man", "command": ""}


def bare_node(actions):
    """A node with a dead-man, without ROS."""
    node = object.__new__(PedalNode)
    node._config = pedal_config({**load_yaml(CONFIG_DIR / "pedal.yaml"), "bindings": [HELD]})
    node._pedals, node._lock, node._trouble = Pedals(node._config), threading.Lock(), ""
    node._carry_out = actions.extend
    return node


@pytest.mark.parametrize("error", [OSError("No such device"), ValueError("strange bytes")])
def test_a_device_that_fails_releases_the_dead_man(monkeypatch, error):
    def fail(name):
        raise error

    turns = iter([False, True])
    fake = SimpleNamespace(
        is_shutdown=lambda: next(turns),
        logwarn=lambda *_: None,
        rostime=SimpleNamespace(wallsleep=lambda _: None),
    )
    monkeypatch.setattr(pedal_node, "rospy", fake)
    monkeypatch.setattr(pedal_node, "find", fail)
    node = bare_node(actions := [])
    node._pedals.found()
    for value in (0.0, 1.0):
        node._pedals.take({"button 0": value})
    assert node._pedals.is_held
    node._read()
    assert not node._pedals.is_held
    assert isinstance(actions[0], Brake) and str(error) in actions[0].why


def connection(name, **state):
    return SimpleNamespace(**{"callerid_pub": name, "done": False, "socket": object(), **state})


class Driven:
    """A node on joy without ROS; `connections` are those of its topic."""

    def __init__(self, monkeypatch, *names):
        log = {"loginfo": lambda *_: None, "logwarn": lambda *_: None}
        monkeypatch.setattr(pedal_node, "rospy", SimpleNamespace(**log))
        self.connections, self.actions = [connection(name) for name in names], []
        node = self.node = bare_node(self.actions)
        node._state, node._last_stop = "", 0.0
        node._known = SimpleNamespace(is_believed=lambda by, name: name in JOYS)
        node._joy = SimpleNamespace(
            impl=SimpleNamespace(connections=self.connections),
            get_num_connections=lambda: len(self.connections),
        )
        node._set_by = {}

    def step(self, name, *buttons, axes=()):
        message = Joy(buttons=buttons, axes=axes)
        message._connection_header = {"callerid": name}
        self.node._on_joy(message)

    def press(self, name):
        for value in (0, 1):
            self.step(name, value)

    def lose(self, name):
        """One that is killed; the rest of its connection stays for a moment."""
        for one in self.connections:
            if one.callerid_pub == name:
                one.done = True

    def check(self):
        """Look at the silence; gives whether the dead-man is still held."""
        self.node._check()
        return self.node._pedals.is_held


JOYS = ("/joy_node", "/joy")


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
