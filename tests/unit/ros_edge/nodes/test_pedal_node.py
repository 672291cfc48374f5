# SPDX-License-Identifier: BSD-3-Clause
"""A pedal that can no longer be read counts as released; what is said of one that sent nothing."""

import threading
import time
from dataclasses import replace
from types import SimpleNamespace

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from sensor_msgs.msg import Joy

from typed_config import load_yaml
from voice_assist.config import CONFIG_DIR
from voice_assist.config.pedal import pedal_config
from voice_assist.pedal import evdev
from voice_assist.pedal.drivers import Drivers
from voice_assist.pedal.evdev import EventsLostError
from voice_assist.pedal.pedals import Brake, Pedals, Send
from voice_assist.ros.pedal import node as pedal_node
from voice_assist.ros.pedal.node import PedalNode

HELD = {"input": "button 0", "above": 0.5, "does": "dead_man", "command": ""}


def bare_node(actions, bound=HELD):
    """A node with a dead-man, without ROS."""
    node = object.__new__(PedalNode)
    node._config = pedal_config({**load_yaml(CONFIG_DIR / "pedal.yaml"), "bindings": [bound]})
    node._pedals, node._lock = Pedals(node._config), threading.Lock()
    node._drivers, node._news = Drivers(node._config, node._pedals, node._is_alive), {}
    node._trouble = node._late = ""
    node._carry_out = lambda some, why_not="": actions.extend(some)
    node._tell = lambda: None
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


def bits(length, *codes):
    made = bytearray(length)
    for code in codes:
        made[code // 8] |= 1 << code % 8
    return bytes(made)


@pytest.mark.parametrize("source", ["button 48", "button 49", "axis 1", "axis 2"])
@pytest.mark.parametrize("does", ["talk", "mute"])
def test_an_input_that_a_usb_pedal_does_not_have_is_named_and_closes_the_gate(
    monkeypatch, tmp_path, source, does
):
    state = {0x80604521: bits(96, 48), 0x80084523: bits(8, 1)}  # EVIOCGBIT of keys, of axes
    monkeypatch.setattr(evdev.fcntl, "ioctl", lambda _, request, at: state.get(request, at))
    (tmp_path / "event1").write_bytes(b"")
    turns, said = iter([False, True]), []
    fake = SimpleNamespace(
        is_shutdown=lambda: next(turns),
        loginfo=lambda *_: None,
        logwarn=lambda words, *parts: said.append(words % parts),
        rostime=SimpleNamespace(is_wallclock=lambda: True, wallsleep=lambda _: None),
    )
    monkeypatch.setattr(pedal_node, "rospy", fake)
    monkeypatch.setattr(pedal_node, "DEVICES", tmp_path)
    monkeypatch.setattr(pedal_node, "find", lambda _: "event1")
    bound = {"input": source, "above": 0.5, "does": does, "command": ""}
    node, may_talk = bare_node([], bound), []
    node._carry_out = lambda *_: may_talk.append(node._pedals.may_talk)
    node._read()
    is_there = source in ("button 48", "axis 1")
    words = f"pedal: the device has no {source}, which pedal.yaml names"
    assert (said[0] == words) is not is_there and said.count(words) <= 1
    assert any(may_talk) is (is_there and does == "mute")


def connection(name, **state):
    return SimpleNamespace(**{"callerid_pub": name, "done": False, "socket": object(), **state})


class Driven:
    """A node on joy without ROS; `connections` are those of its topic."""

    def __init__(self, monkeypatch, *names, bound=HELD):
        log = {"loginfo": lambda *_: None, "logwarn": lambda *_: None}
        monkeypatch.setattr(pedal_node, "rospy", SimpleNamespace(**log))
        self.connections, self.actions = [connection(name) for name in names], []
        node = self.node = bare_node(self.actions, bound)
        node._known, node._dead_man = SimpleNamespace(is_believed=is_believed), None
        monkeypatch.setattr(pedal_node, "open_listeners", lambda _: {CONTROLLER})
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


JOYS, CONTROLLER = ("/joy_node", "/joy"), "/controller"


def is_believed(by, name):
    return name in {"joy": JOYS, "controller": (CONTROLLER,)}[by]


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
BRAKED = ["stop is published", "stop"]  # by the topic, and by the service that is looked up anew


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
        node._drivers, node._news = Drivers(node._config, node._pedals, node._is_alive), {}
        monkeypatch.setattr(node._pedals, "_clock", iter(range(1000)).__next__)
        node._trouble, node._late, node._joy = "", "", None
        node._stop = SimpleNamespace(publish=lambda _: self.acts.append("stop is published"))
        call = lambda command, may_repeat: self.acts.append(command)  # noqa: E731
        node._client = SimpleNamespace(call=call, forget=lambda: None)
        told = lambda message: self.acts.append(f"dead-man {message.data}")  # noqa: E731
        node._dead_man = SimpleNamespace(publish=told)
        node._known = SimpleNamespace(is_believed=is_believed)
        self.listeners = {CONTROLLER}  # of the dead-man
        monkeypatch.setattr(pedal_node, "open_listeners", lambda _: self.listeners)
        node._pedals.found()
        node._pedals.take(dict.fromkeys(("button 0", "button 1"), 0.0))


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


# Events that the kernel had no room for; a tap of a stop may be among them.


@pytest.mark.parametrize(
    ("bound", "acts"),
    [((STOP, MORE), BRAKED), ((MORE,), []), ((STOP, {**HELD, "input": "button 1"}), BRAKED)],
)
def test_lost_events_stop_where_a_stop_is_bound_and_the_device_is_opened_at_once(
    monkeypatch, bound, acts
):
    """After a loss of another kind it is looked for after a while only."""
    acting, opened = Acting(monkeypatch, *bound), []

    class Reader:
        stamp = 0.0

        def __init__(self, *_):
            opened.append(self)
            acting.acts.append("opened")

        def __enter__(self):
            return self

        def __exit__(self, *_):
            pass

        def inputs(self):
            return {"button 0", "button 1"}

        def __iter__(self):
            yield {"button 0": 0.0, "button 1": 0.0}
            raise EventsLostError("events were lost") if len(opened) == 1 else OSError("unplugged")

    acting.rospy.is_shutdown = lambda: "waited" in acting.acts
    acting.rospy.rostime.wallsleep = lambda _: acting.acts.append("waited")
    monkeypatch.setattr(pedal_node, "EvdevReader", Reader)
    monkeypatch.setattr(pedal_node, "find", lambda _: "event1")
    acting.node._read()
    assert acting.acts == ["opened", *acts, "opened", "waited"]
    assert any("a stop may have been among them" in words for words in acting.words) is bool(acts)


def test_lost_events_while_the_dead_man_is_held_stop_once_and_release_it(monkeypatch):
    acting = Acting(monkeypatch, HELD, {**STOP, "input": "button 1"})
    acting.node._take({"button 0": 1.0})
    acting.acts.clear()
    acting.node._lost("events were lost", are_events_lost=True)
    acting.node._tell()
    assert acting.acts == [*BRAKED, "dead-man False"]
