# SPDX-License-Identifier: BSD-3-Clause
"""CRTK's commands that wait, where a later one stops the robot."""

import threading
from queue import Queue
from types import SimpleNamespace

import pytest

from rst_control.ros.crtk import node as node_module
from rst_control.ros.crtk.node import DROPPED, STOPPED_AGAIN, CrtkNode
from rst_control.srv import Command
from support.waiting import wait_until
from typed_config.ros.service_calls import Reply

ACCEPTED = Reply(SimpleNamespace(accepted=True))


def node():
    stops, it = [], object.__new__(CrtkNode)
    it._stop, it._commands = SimpleNamespace(publish=stops.append), Queue(8)
    it._brakes, it.warned = 0, []
    it._warn = it.warned.append
    return it, stops


def says(it, words):
    """In the order in which rospy calls the subscribers of one topic."""
    it._on_brake(SimpleNamespace(string=words))
    it._on_command(SimpleNamespace(string=words))


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
