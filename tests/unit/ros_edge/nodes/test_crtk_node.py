# SPDX-License-Identifier: BSD-3-Clause
"""CRTK's commands that wait, where a later one stops the robot."""

from queue import Queue
from types import SimpleNamespace

import pytest

from rst_control.ros.crtk.node import DROPPED, STOPPED_AGAIN, CrtkNode


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


@pytest.mark.parametrize(("words", "given"), [("enable", []), ("disable", ["terminate"])])
def test_what_was_taken_from_the_queue_is_dropped_too_while_it_waits_for_the_controller(
    words, given
):
    it, _ = node()
    says(it, words)

    class Slow:
        def wait_for_service(self, _):
            says(it, "pause")

        def __call__(self, command):
            asked.append(command)
            return SimpleNamespace(accepted=True)

    asked, it._command = [], Slow()
    it._give(*it._commands.get())
    assert asked == given
    assert it.warned == ([] if given else [f"hey robot: {DROPPED}"])


@pytest.mark.parametrize("words", ["enable", "disable"])
def test_what_reaches_the_controller_after_a_pause_is_undone(words):
    it, stops = node()
    says(it, words)
    before = len(stops)

    class Slow:
        def wait_for_service(self, _):
            pass

        def __call__(self, command):
            says(it, "pause")
            return SimpleNamespace(accepted=True)

    it._command = Slow()
    it._give(*it._commands.get())
    assert len(stops) - before == (2 if words == "enable" else 1)
    assert it.warned == ([f"hey robot: {STOPPED_AGAIN}"] if words == "enable" else [])
