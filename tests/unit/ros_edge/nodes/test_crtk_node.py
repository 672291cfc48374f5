# SPDX-License-Identifier: BSD-3-Clause
"""CRTK's commands that wait, where a later one stops the robot."""

import threading
import time
from queue import Queue
from types import SimpleNamespace

import pytest
import rospy
from crtk_msgs.msg import StringStamped

from rst_control.ros.crtk import node as node_module
from rst_control.ros.crtk.node import DROPPED, STOPPED_AGAIN, CrtkNode
from rst_control.srv import Command
from support.waiting import wait_until
from typed_config.ros.service_calls import Reply

ACCEPTED = Reply(SimpleNamespace(accepted=True))


def node():
    stops, it = [], object.__new__(CrtkNode)
    it._stop, it._commands = SimpleNamespace(publish=stops.append), Queue(8)
    it._brakes, it._newest, it.warned = 0, {}, []
    it._warn = it.warned.append
    return it, stops


def says(it, words):
    """In the order in which rospy calls the subscribers of one topic."""
    hear(it, StringStamped(string=words))


def hear(it, message):
    it._on_brake(message)
    it._on_command(message)


@pytest.mark.parametrize(("last", "left"), [("pause", []), ("disable", ["terminate"])])
def test_what_waits_is_dropped_by_what_stops(last, left):
    it, stops = node()
    says(it, "resume")
    says(it, "resume")
    assert not stops and it._commands.qsize() == 2
    says(it, last)
    assert len(stops) == 1
    assert [it._commands.get()[0] for _ in range(it._commands.qsize())] == left
    assert it.warned == [f"hey robot: {DROPPED}"]


def test_a_pause_does_not_take_back_that_assistance_ends():
    it, stops = node()
    for words in ("enable", "disable", "pause"):
        says(it, words)
    assert len(stops) == 2
    assert [it._commands.get()[0] for _ in range(it._commands.qsize())] == ["terminate"]


def calls(monkeypatch, on_call, reply=ACCEPTED):
    """What the controller's service is asked; `on_call` happens before it would be sent."""
    asked = []

    def call_service(name, kind, command, *, within, appears, is_void):
        assert (name, kind, within, appears) == ("rst_control/command", Command, 2.0, 2.0)
        on_call()
        if is_void():
            return Reply(None, "given up before it was sent")
        asked.append(command)
        return reply() if callable(reply) else reply

    monkeypatch.setattr(node_module, "call_service", call_service)
    return asked


@pytest.mark.parametrize(("words", "given"), [("enable", []), ("disable", ["terminate"])])
def test_what_was_taken_from_the_queue_is_dropped_too_while_it_waits_for_the_controller(
    monkeypatch, words, given
):
    it, _ = node()
    says(it, words)
    asked = calls(monkeypatch, lambda: says(it, "pause"))
    it._give(*it._commands.get())
    assert asked == given
    assert it.warned == ([] if given else [f"hey robot: {DROPPED}"])


UNKNOWN = Reply(None, "no answer within 2 s", may_take_effect=True)


@pytest.mark.parametrize("answer", [ACCEPTED, UNKNOWN])
@pytest.mark.parametrize("words", ["enable", "disable"])
def test_what_may_reach_the_controller_after_a_pause_is_undone(monkeypatch, words, answer):
    it, stops = node()
    says(it, words)
    before = len(stops)

    def answered():
        says(it, "pause")
        return answer

    calls(monkeypatch, lambda: None, answered)
    it._give(*it._commands.get())
    assert len(stops) - before == (2 if words == "enable" else 1)
    unanswered = [f"terminate: {UNKNOWN.trouble}"] if answer is UNKNOWN else []
    assert it.warned == ([f"hey robot: {STOPPED_AGAIN}"] if words == "enable" else unanswered)


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (Reply(SimpleNamespace(accepted=False, message="busy")), "hey robot: refused; busy"),
        (Reply(None, "no answer within 2 s"), "hey robot: no answer within 2 s"),
    ],
)
def test_a_refusal_and_a_silence_are_warnings(monkeypatch, answer, words):
    it, stops = node()
    says(it, "resume")
    calls(monkeypatch, lambda: None, answer)
    it._give(*it._commands.get())
    assert it.warned == [words] and not stops


def test_the_state_is_published_while_a_call_hangs(monkeypatch):
    it, _ = node()
    is_over, published = threading.Event(), []
    it._commands.put(("hey robot", 0))
    it._publish_state = lambda: published.append(is_called.is_set())
    it._known = SimpleNamespace(publish_status=lambda: None)
    is_called = threading.Event()

    def hang(*_, **__):
        is_called.set()
        is_over.wait()
        return Reply(None, "no answer")

    def is_shutdown():
        return is_over.is_set()

    monkeypatch.setattr(node_module, "call_service", hang)
    monkeypatch.setattr(node_module.rospy, "is_shutdown", is_shutdown)
    running = threading.Thread(target=it.run, daemon=True)
    running.start()
    try:
        wait_until(lambda: sum(published) > 2, "states while a call hangs")
    finally:
        is_over.set()
    running.join()


# A client's newest command reaches each new connection, where its publisher keeps it (latches).


class Client:
    """A client as crtk_python_client makes it: its messages are latched and have no stamp."""

    def __init__(self, it, latching="1"):
        self.it, self.latching = it, latching
        self.connect()

    def connect(self):
        self.header = {"callerid": "/client", "latching": self.latching}

    def gives(self, words, age=None):
        message = StringStamped(string=words)
        if age is not None:
            message.header.stamp = rospy.Time.from_sec(time.time() - age)
        message._connection_header = self.header
        hear(self.it, message)
        return self.it._commands.qsize()


@pytest.fixture(autouse=True)
def clock(monkeypatch):
    monkeypatch.setattr(rospy, "get_time", time.time)


@pytest.mark.parametrize("words", ["enable", "resume", " Enable "])
@pytest.mark.parametrize("age", [None, 60.0, -60.0])
def test_a_latched_command_of_before_the_connection_wakes_nobody(words, age):
    it, stops = node()
    client = Client(it)
    assert client.gives(words, age) == 0 and not stops
    (warned,) = it.warned
    assert "may be from before this connection: give it again" in warned
    assert client.gives(words, age) == 1  # given again
    client.connect()
    assert client.gives(words, age) == 1 and len(it.warned) == 2


@pytest.mark.parametrize(("latching", "age"), [("1", 0.2), ("1", -0.2), ("0", None), ("0", 60.0)])
def test_a_command_with_a_stamp_of_now_or_that_is_not_latched_counts_at_once(latching, age):
    it, _ = node()
    assert Client(it, latching).gives("enable", age) == 1 and not it.warned


def test_a_latched_brake_of_before_the_connection_brakes_and_a_later_command_counts():
    it, stops = node()
    client = Client(it)
    assert client.gives("disable") == 1 and len(stops) == 1
    assert it._commands.get()[0] == "terminate"
    assert client.gives("enable") == 1 and not it.warned


def test_each_clients_connection_has_its_own_first_command():
    it, _ = node()
    first, second = Client(it), Client(it)
    second.header["callerid"] = "/other"
    assert first.gives("enable") == 0
    assert second.gives("enable") == 0
    assert first.gives("enable") == 1
