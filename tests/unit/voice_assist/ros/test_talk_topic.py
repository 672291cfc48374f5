# SPDX-License-Identifier: BSD-3-Clause
"""The pedal's gate: closed by silence, and from the start in a voice node that is restarted."""

import threading

import pytest
import rospy
from std_msgs.msg import Bool

from rst_control.host.respawn import RESTART
from support.waiting import wait_until
from tests.unit.voice_assist.support.heard import Heard
from voice_assist.audio.talk_gate import TalkGate
from voice_assist.ros import node_settings
from voice_assist.ros.talk_topic import SILENT_AFTER, TalkTopic


class Node:
    """A voice node's gate, whose messages and clock a test makes."""

    def __init__(self):
        self.now, self.heard, self.gate = 100.0, Heard(), TalkGate()
        self.topic = TalkTopic(lambda: self.now, self.heard)

    def hear(self, is_open):
        self.heard.callbacks["voice_assist/talk"](Bool(is_open))

    def counts(self):
        """Whether voice counts in the next second."""
        for change in self.topic.take():
            self.gate.update(change)
        self.now += 1.0
        return self.gate.was_open(self.now - 1.0, self.now)


@pytest.fixture
def kept(monkeypatch):
    """Parameters that the master keeps."""
    kept = {}
    monkeypatch.delenv(RESTART, raising=False)
    monkeypatch.setattr(rospy, "set_param", kept.__setitem__)
    monkeypatch.setattr(rospy, "get_param", kept.get)
    return kept


def test_voice_counts_until_a_gate_is_heard_and_not_after_its_silence(kept):
    node = Node()
    assert node.counts() and not kept
    node.hear(True)
    assert node.counts()
    node.now += 1.1 * SILENT_AFTER
    assert not node.counts()


@pytest.mark.parametrize("was_open", [True, False])
def test_a_voice_node_that_is_restarted_hears_no_command_until_the_gate_is_heard_again(
    kept, monkeypatch, was_open
):
    Node().hear(was_open)
    wait_until(lambda: kept, "the gate on the master")
    monkeypatch.setenv(RESTART, "1")
    node = Node()
    assert not node.counts() and not node.counts()  # the pedal node hangs
    node.hear(True)
    assert node.counts()


def test_without_a_gate_a_voice_node_that_is_restarted_hears_at_once(kept, monkeypatch):
    monkeypatch.setenv(RESTART, "1")
    assert Node().counts()


def test_the_gate_of_an_earlier_launch_is_none(kept):
    Node().hear(True)
    wait_until(lambda: kept, "the gate on the master")
    assert Node().counts()


def test_a_gate_is_kept_once_and_no_setting_of_the_launch(kept, monkeypatch):
    sets = []
    monkeypatch.setattr(rospy, "set_param", lambda *given: sets.append(given))
    node = Node()
    for is_open in (True, False, True):
        node.hear(is_open)
    wait_until(lambda: sets, "the gate on the master")
    assert [name.removeprefix("~") in node_settings.OWN for name, _ in sets] == [True]


def test_a_master_that_hangs_keeps_no_gate_from_closing(kept, monkeypatch):
    answers = threading.Event()
    monkeypatch.setattr(rospy, "set_param", lambda *_: answers.wait())
    node = Node()
    try:
        node.hear(True)
        assert node.counts()
        node.hear(False)
        assert not node.counts()
    finally:
        answers.set()
