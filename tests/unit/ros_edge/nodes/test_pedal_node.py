# SPDX-License-Identifier: BSD-3-Clause
"""A pedal that can no longer be read counts as released; what is said of one that sent nothing."""

import threading
import time
from types import SimpleNamespace

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from sensor_msgs.msg import Joy

from support.waiting import PATIENCE, wait_until
from typed_config import load_yaml
from voice_assist.config import CONFIG_DIR
from voice_assist.config.pedal import pedal_config
from voice_assist.pedal.pedals import Brake, Pedals
from voice_assist.ros.pedal import node as pedal_node
from voice_assist.ros.pedal.node import PedalNode
from voice_assist.ros.pedal.words import Words

HELD = {"input": "button 0", "above": 0.5, "does": "dead_man", "command": ""}


def bare_node(actions):
    """A node with a dead-man, without ROS."""
    node = object.__new__(PedalNode)
    node._config = pedal_config({**load_yaml(CONFIG_DIR / "pedal.yaml"), "bindings": [HELD]})
    node._pedals, node._lock, node._trouble = Pedals(node._config), threading.Lock(), ""
    node._carry_out = lambda some, why_not="": actions.extend(some)
    node._say = lambda log, *words: log(*words)
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


# What a press does to the robot, by a node whose publisher and client only note it.

STOP = {**HELD, "does": "command", "command": "stop"}
MORE = {**STOP, "input": "button 1", "command": "pull more"}


class Acting:
    """A node that acts; `acts` are its stops and commands, `words` what it logs."""

    def __init__(self, monkeypatch, *bindings):
        self.acts, self.words = [], []
        note = lambda words, *parts: self.words.append(words % parts)  # noqa: E731
        clock = {"rostime": SimpleNamespace(is_wallclock=lambda: self.is_wallclock)}
        fake = SimpleNamespace(loginfo=note, logwarn=note, get_time=time.time, **clock)
        monkeypatch.setattr(pedal_node, "rospy", fake)
        self.is_wallclock, self.rospy = True, fake
        node = self.node = object.__new__(PedalNode)
        node._config = pedal_config(
            {**load_yaml(CONFIG_DIR / "pedal.yaml"), "bindings": list(bindings)}
        )
        node._pedals, node._lock = Pedals(node._config), threading.Lock()
        monkeypatch.setattr(node._pedals, "_clock", iter(range(1000)).__next__)
        node._trouble, node._state, node._joy, node._last_stop = "", "", None, 0.0
        node._say = lambda log, *words: log(*words)
        node._stop = SimpleNamespace(publish=lambda _: self.acts.append("stop is published"))
        call = lambda command, may_repeat: self.acts.append(command)  # noqa: E731
        node._client = SimpleNamespace(call=call, forget=lambda: None)
        node._pedals.found()
        node._pedals.take(dict.fromkeys(("button 0", "button 1"), 0.0))


@pytest.mark.parametrize("bound", [STOP, HELD])
def test_no_stop_waits_for_a_log_that_blocks(monkeypatch, bound):
    acting, goes_on, is_blocked = Acting(monkeypatch, bound, MORE), threading.Event(), []

    def block(words, *parts):
        is_blocked.append(words % parts)
        goes_on.wait()

    acting.rospy.loginfo = acting.rospy.logwarn = block
    acting.node._say = Words()
    values = [{"button 1": 1}, {"button 0": 1}, {"button 0": 0}]  # the first blocks the log

    def press():
        for one in values:
            with acting.node._lock:
                acting.node._take(one)

    pressing = threading.Thread(target=press, daemon=True)
    try:
        pressing.start()
        wait_until(lambda: "stop is published" in acting.acts, "a stop")
        pressing.join(PATIENCE)
        acting.node._check()
        wait_until(lambda: is_blocked, "a log that blocks")
        assert not pressing.is_alive() and len(is_blocked) == 1
    finally:
        goes_on.set()
    acting.node._say.close(PATIENCE)
    assert is_blocked[0] == "pedal: pull more, by button 1" and len(is_blocked) == 2


def test_words_that_nobody_can_write_are_lost_and_keep_nobody_waiting(monkeypatch):
    monkeypatch.setattr("voice_assist.ros.pedal.words.KEPT", 2)
    goes_on, written, words = threading.Event(), [], Words()
    words(goes_on.wait)
    for number in range(9):
        words(written.append, number)
    words.close(0.0)
    goes_on.set()
    wait_until(lambda: written, "the first word")
    assert written[0] == 0 and len(written) < 4


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
    for value in (1.0, 0.0):
        acting.node._take({"button 0": value}, time.time() - 60.0)
    assert acting.acts == ["stop is published"]


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
