# SPDX-License-Identifier: BSD-3-Clause
"""A pedal node without ROS, whose publisher and client only note what it does."""

import threading
import time
from types import SimpleNamespace

from sensor_msgs.msg import Joy

from typed_config import load_yaml
from voice_assist.config import CONFIG_DIR
from voice_assist.config.pedal import pedal_config
from voice_assist.pedal.drivers import Drivers
from voice_assist.pedal.pedals import Pedals
from voice_assist.ros.pedal import node as pedal_node
from voice_assist.ros.pedal.node import PedalNode

HELD = {"input": "button 0", "above": 0.5, "does": "dead_man", "command": ""}
STOP = {**HELD, "does": "command", "command": "stop"}
MORE = {**STOP, "input": "button 1", "command": "pull more"}
BRAKED = ["stop is published", "stop"]  # by the topic, and by the service that is looked up anew
JOYS, CONTROLLER = ("/joy_node", "/joy"), "/controller"


def bare_node(*bindings):
    """A node without ROS, which cannot act yet."""
    node = object.__new__(PedalNode)
    settings = {**load_yaml(CONFIG_DIR / "pedal.yaml"), "bindings": list(bindings)}
    node._config = pedal_config(settings)
    node._pedals, node._lock = Pedals(node._config), threading.Lock()
    node._drivers, node._news = Drivers(node._config, node._pedals, node._is_alive), {}
    node._trouble = node._late = ""
    return node


def noting_node(actions, bound=HELD):
    """A node that notes what it would carry out."""
    node = bare_node(bound)
    node._carry_out = lambda some, why_not="": actions.extend(some)
    node._tell = lambda: None
    return node


def connection(name, **state):
    return SimpleNamespace(**{"callerid_pub": name, "done": False, "socket": object(), **state})


class Driven:
    """A node on joy without ROS; `connections` are those of its topic."""

    def __init__(self, monkeypatch, *names, bound=HELD):
        log = {"loginfo": lambda *_: None, "logwarn": lambda *_: None}
        monkeypatch.setattr(pedal_node, "rospy", SimpleNamespace(**log))
        self.connections, self.actions = [connection(name) for name in names], []
        node = self.node = noting_node(self.actions, bound)
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


def is_believed(by, name):
    return name in {"joy": JOYS, "controller": (CONTROLLER,)}[by]


class Acting:
    """A node that acts; `acts` are its stops and commands, `words` what it logs."""

    def __init__(self, monkeypatch, *bindings):
        self.acts, self.words = [], []
        note = lambda words, *parts: self.words.append(words % parts)  # noqa: E731
        clock = {"rostime": SimpleNamespace(is_wallclock=lambda: self.is_wallclock)}
        fake = SimpleNamespace(loginfo=note, logwarn=note, get_time=time.time, **clock)
        monkeypatch.setattr(pedal_node, "rospy", fake)
        self.is_wallclock, self.rospy = True, fake
        node = self.node = bare_node(*bindings)
        monkeypatch.setattr(node._pedals, "_clock", iter(range(1000)).__next__)
        node._joy = None
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
