# SPDX-License-Identifier: BSD-3-Clause
"""A pedal that can no longer be read counts as released; what is said of one that sent nothing."""

import threading
from types import SimpleNamespace

import pytest
from diagnostic_msgs.msg import DiagnosticStatus

from typed_config import load_yaml
from voice_assist.config import CONFIG_DIR
from voice_assist.config.pedal import pedal_config
from voice_assist.pedal.pedals import Brake, Pedals
from voice_assist.ros.pedal import node as pedal_node
from voice_assist.ros.pedal.node import PedalNode

HELD = {"input": "button 0", "above": 0.5, "does": "dead_man", "command": ""}


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
    node, actions = object.__new__(PedalNode), []
    node._config = pedal_config({**load_yaml(CONFIG_DIR / "pedal.yaml"), "bindings": [HELD]})
    node._pedals, node._lock, node._trouble = Pedals(node._config), threading.Lock(), ""
    node._carry_out = actions.extend
    node._pedals.found()
    for value in (0.0, 1.0):
        node._pedals.take({"button 0": value})
    assert node._pedals.is_held
    node._read()
    assert not node._pedals.is_held
    assert isinstance(actions[0], Brake) and str(error) in actions[0].why


@pytest.mark.parametrize(
    ("publishers", "trouble", "is_well"),
    [(0, pedal_node.NOT_FOUND, False), (1, pedal_node.NOT_FOUND, True), (1, "silent", False)],
)
def test_a_joy_that_sends_changes_only_is_there_once_it_is_connected(publishers, trouble, is_well):
    node = object.__new__(PedalNode)
    node._joy, node._trouble = SimpleNamespace(get_num_connections=lambda: publishers), trouble
    level, words = node._state_of_device()
    assert (level == DiagnosticStatus.OK) is is_well
    assert is_well or words == trouble
