# SPDX-License-Identifier: BSD-3-Clause
"""A dead-man that is released or silent lets nothing move; a system without one is free."""

from types import SimpleNamespace

import pytest

from rst_control.admission.command_queue import CommandQueue
from rst_control.admission.dead_man_gate import DeadMan, HeldOnly
from rst_control.ros.controller import dead_man_link
from rst_control.ros.controller.dead_man_link import HAS_DEAD_MAN, DeadManLink
from rst_control.types import Reason, State
from support.waiting import wait_until
from tests.unit.rst_control.support.executor_rig import Rig

ALLOWED = 0.5  # [s]


@pytest.fixture(autouse=True)
def kept(monkeypatch):
    """Parameters that a restart finds."""
    kept = {}
    rospy = SimpleNamespace(get_param=kept.get, set_param=kept.__setitem__)
    monkeypatch.setattr(dead_man_link, "rospy", rospy)
    return kept


class Held(Rig):
    """A controller with a dead-man whose words are given by hand, looked at each 20 ms."""

    def __init__(self):
        super().__init__()
        dead_man = DeadMan(ALLOWED, lambda: self.now)
        verify = HeldOnly(self.context.verify, dead_man)
        self.queue = CommandQueue(self.executor, verify, lambda: self.now)
        hears = {}
        known = SimpleNamespace(
            subscribe=lambda topic, kind, take, names, **_: hears.update({topic: (take, names)})
        )
        self.link = DeadManLink(dead_man, self.executor, known, ("/pedal",))
        self.word, self.believed = hears["rst_control/dead_man"]

    def speak(self, is_held):
        self.word(SimpleNamespace(data=is_held))

    def looked(self, seconds, is_held=None):
        """Go on, with a word each 50 ms where there is one; gives the state."""
        for step in range(round(seconds / 0.01)):
            if is_held is not None and step % 5 == 0:
                self.speak(is_held)
            self.run(0.01)
            if step % 2 == 0:
                self.link.check(self.view)
        return self.run(0.01).state


def test_without_a_dead_man_everything_moves():
    rig = Held().awake()
    rig.say("tense")
    assert rig.looked(2 * ALLOWED) is State.MOVING


def test_only_a_pedal_that_is_believed_is_heard():
    assert Held().believed == ("/pedal",)


def test_a_motion_is_refused_while_it_is_not_pressed_and_nothing_latches():
    rig = Held().awake()
    rig.speak(False)
    assert rig.refused("tense") == "the dead-man is not pressed"
    assert rig.state is State.ACTIVE and rig.still_for(0.1)
    rig.speak(True)
    rig.say("tense")
    assert rig.looked(2 * ALLOWED, is_held=True) is State.MOVING


@pytest.mark.parametrize("word", [True, False])
def test_what_moves_nothing_needs_no_dead_man(word):
    rig = Held()
    rig.speak(word)
    rig.run(2 * ALLOWED)
    for command, state in (
        ("hey robot", State.ACTIVE),
        ("stop", State.HALTED),
        ("hey robot", State.ACTIVE),
        ("terminate", State.STANDBY),
    ):
        rig.say(command)
        assert rig.state is state


def test_one_that_is_released_brakes_by_its_own_reason():
    rig = Held().awake()
    rig.speak(True)
    rig.say("tense")
    assert rig.looked(1.0, is_held=True) is State.MOVING
    rig.speak(False)
    assert rig.looked(0.02) is not State.MOVING
    rig.rest()
    assert rig.state is State.HALTED
    assert rig.view.mode.cause.reason is Reason.DEAD_MAN


def test_one_that_falls_silent_while_held_brakes_and_refuses():
    rig = Held().awake()
    rig.speak(True)
    rig.say("tense")
    assert rig.looked(ALLOWED - 0.03) is State.MOVING
    assert rig.looked(0.06) is not State.MOVING
    rig.rest()
    assert rig.state is State.HALTED and "silent for 0.5 s" in rig.view.mode.reason
    rig.say("hey robot")
    assert "silent" in rig.refused("tense")
    rig.speak(True)
    rig.say("tense")


def test_a_stop_that_came_first_keeps_its_reason():
    rig = Held().awake()
    rig.speak(True)
    rig.say("tense")
    rig.looked(1.0, is_held=True)
    rig.stop()
    rig.tick()
    rig.speak(False)
    rig.looked(1.0, is_held=False)
    assert rig.view.mode.cause.reason is Reason.STOP_TOPIC


def test_a_controller_that_is_started_anew_still_asks_for_it(kept):
    first = Held().awake()
    first.say("tense")
    first.stop()
    assert not kept
    first.speak(True)
    wait_until(lambda: kept == {HAS_DEAD_MAN: True})
    again = Held().awake()
    assert again.refused("tense") == "the dead-man is not pressed"
    again.run(2 * ALLOWED)
    assert "silent" in again.refused("tense")
    again.speak(True)
    again.say("tense")
