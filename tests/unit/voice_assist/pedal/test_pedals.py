# SPDX-License-Identifier: BSD-3-Clause
"""From presses to commands, talk gate and dead-man; and what must do nothing."""

import math

import pytest

from typed_config import ConfigError, load_yaml
from voice_assist.config import CONFIG_DIR
from voice_assist.config.pedal import pedal_config
from voice_assist.errors import CommandsError
from voice_assist.pedal.pedals import Brake, Pedals, Send

FILE = load_yaml(CONFIG_DIR / "pedal.yaml")


def binding(source, does="command", command="", above=0.5):
    return {"input": source, "above": above, "does": does, "command": command}


class Steps:
    """A clock that goes on by so many seconds each time it is read."""

    def __init__(self, step):
        self._step, self._now = step, 0.0

    def __call__(self):
        self._now += self._step
        return self._now


def make(*bindings, clock=None):
    pedals = Pedals(pedal_config({**FILE, "bindings": list(bindings)}), clock or Steps(1.0))
    pedals.found()
    return pedals


def press(pedals, name, value=1.0):
    return pedals.take({name: value})


def test_a_press_sends_its_command_once():
    pedals = make(binding("button 1", command="pull more"))
    seen = [press(pedals, "button 1", value) for value in (0, 1, 1, 0, 1)]
    sent = (Send("pull more", "button 1"),)
    assert seen == [(), sent, (), (), sent]


def test_what_is_pressed_from_the_start_counts_only_after_a_release():
    pedals = make(binding("button 1", command="tense"))
    assert [press(pedals, "button 1", value) for value in (1, 1, 0)] == [(), (), ()]
    assert press(pedals, "button 1") == (Send("tense", "button 1"),)


def test_a_stop_counts_once_though_it_is_pressed_from_the_start():
    pedals = make(binding("button 0", command="stop"), binding("button 1", command="tense"))
    sent = (Send("stop", "button 0"),)
    assert pedals.take({"button 0": 1.0, "button 1": 1.0}) == sent
    assert [press(pedals, "button 0", value) for value in (1, 0, 1)] == [(), (), sent]
    pedals.lost("unplugged")
    pedals.found()
    assert press(pedals, "button 0") == sent


def test_after_a_loss_a_pressed_button_counts_only_after_a_release():
    pedals = make(binding("button 1", command="tense"))
    press(pedals, "button 1", 0.0)
    assert pedals.lost("unplugged") == ()
    pedals.found()
    assert press(pedals, "button 1") == ()


@pytest.mark.parametrize(
    ("above", "values", "sent"),
    [
        (0.5, (0.0, 0.49, 0.5, 1.0, 0.2, 0.6), 2),
        (-0.5, (0.0, -0.49, -0.5, -1.0, 0.0), 1),
        (-0.5, (0.0, 1.0), 0),
    ],
)
def test_an_axis_counts_from_its_threshold_on(above, values, sent):
    pedals = make(binding("axis 2", command="pull less", above=above))
    assert sum(len(press(pedals, "axis 2", value)) for value in values) == sent


JITTER = (0, 0.3, 0.49, 0.501, 0.499, 0.502, 0.498, 0.505, 0.6, 1.0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("then", "sent"), [((), 1), ((0.41, 0.6), 1), ((0.39, 0.6), 2)])
def test_an_axis_at_its_threshold_commands_once_until_it_is_clearly_released(sign, then, sent):
    pedals = make(binding("axis 2", command="pull more", above=sign * 0.5))
    seen = [press(pedals, "axis 2", sign * value) for value in (*JITTER, *then)]
    assert sum(map(len, seen)) == sent


def test_an_axis_that_rests_at_its_threshold_from_the_start_commands_nothing():
    pedals = make(binding("axis 2", command="pull more"))
    assert not any(press(pedals, "axis 2", value) for value in (0.6, *JITTER[2:]))


@pytest.mark.parametrize(
    ("does", "command", "acts"),
    [("dead_man", "", Brake("the dead-man (axis 2) is released")), ("command", "stop", None)],
)
def test_a_stop_and_a_release_of_the_dead_man_wait_for_no_clear_release(does, command, acts):
    pedals = make(binding("axis 2", does, command), clock=Steps(0.0))
    acts = acts or Send("stop", "axis 2")
    seen = [press(pedals, "axis 2", value) for value in (0.0, 0.6, 0.49, 0.51, 0.49)]
    assert seen.count((acts,)) == 2


@pytest.mark.parametrize(("apart", "sent"), [(0.001, 1), (0.06, 3)])
def test_a_contact_that_bounces_commands_once(apart, sent):
    now = [0.0]
    pedals = make(binding("button 1", command="pull more"), clock=lambda: now[0])
    press(pedals, "button 1", 0.0)
    now[0], seen = 1.0, []
    for value in (1, 0, 1, 0, 1):
        seen += press(pedals, "button 1", value)
        now[0] += apart
    assert seen == [Send("pull more", "button 1")] * sent
    now[0] += 1.0
    press(pedals, "button 1", 0.0)
    now[0] += 1.0
    assert press(pedals, "button 1") == (Send("pull more", "button 1"),)


def test_a_stop_that_bounces_is_sent_each_time():
    pedals = make(binding("button 0", command="stop"), clock=Steps(0.0))
    assert sum(len(press(pedals, "button 0", value)) for value in (1, 0, 1, 0, 1)) == 3


def test_an_unknown_button_and_one_that_the_device_lacks_are_named_once():
    pedals = make(binding("button 7", command="stop"))
    assert [press(pedals, "button 9", value) for value in (1, 0, 1)] == [(), (), ()]
    assert pedals.remarks == ["button 9 does nothing: pedal.yaml does not name it"]
    pedals.check({"button 0": 0.0})
    assert "no button 7" in pedals.remarks[-1]


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_an_axis_without_a_number_is_released_and_named(bad):
    pedals = make(binding("axis 0", "dead_man"))
    press(pedals, "axis 0", 0.0)
    press(pedals, "axis 0", 1.0)
    assert pedals.is_held
    assert [type(action) for action in press(pedals, "axis 0", bad)] == [Brake]
    assert "no number" in pedals.remarks[0]


def test_the_dead_man_brakes_when_released_and_when_lost():
    pedals = make(binding("button 0", "dead_man"))
    press(pedals, "button 0", 0.0)
    press(pedals, "button 0")
    assert pedals.is_held
    (released,) = press(pedals, "button 0", 0.0)
    assert released == Brake("the dead-man (button 0) is released")
    press(pedals, "button 0")
    (lost,) = pedals.lost("unplugged")
    assert "unplugged" in lost.why and not pedals.is_held
    assert pedals.lost("again") == ()


@pytest.mark.parametrize(("does", "is_open"), [("talk", [False, True]), ("mute", [True, False])])
def test_the_gate_follows_its_pedal_and_is_closed_without_it(does, is_open):
    pedals = make(binding("button 3", does))
    seen = []
    for value in (0.0, 1.0):
        press(pedals, "button 3", value)
        seen.append(pedals.may_talk)
    assert seen == is_open
    pedals.lost("unplugged")
    assert not pedals.may_talk


def test_a_mute_that_is_held_mutes_from_the_start_and_after_a_loss():
    pedals = make(binding("button 3", "mute"))
    assert not pedals.may_talk  # nothing is known yet
    seen = []
    for value in (1.0, 0.0, 1.0):
        press(pedals, "button 3", value)
        seen.append(pedals.may_talk)
    assert seen == [False, True, False]
    pedals.lost("unplugged")
    pedals.found()
    assert not pedals.may_talk
    press(pedals, "button 3", 1.0)
    assert not pedals.may_talk
    press(pedals, "button 3", 0.0)
    assert pedals.may_talk


@pytest.mark.parametrize("does", ["talk", "mute"])
def test_an_axis_without_a_number_closes_the_gate(does):
    pedals = make(binding("axis 0", does))
    for value in (0.0, math.nan):
        press(pedals, "axis 0", value)
    assert not pedals.may_talk
    assert f"it counts as {'pressed' if does == 'mute' else 'released'}" in pedals.remarks[0]


def test_a_talk_that_is_held_from_the_start_opens_nothing():
    pedals = make(binding("button 3", "talk"))
    press(pedals, "button 3")
    assert not pedals.may_talk


def test_without_a_gate_voice_counts():
    pedals = make(binding("button 3", command="stop"))
    assert pedals.may_talk and not pedals.has_gate
    pedals.lost("unplugged")
    assert pedals.may_talk


@pytest.mark.parametrize(
    ("bindings", "words"),
    [
        ([binding("knob 1", command="stop")], "button N or axis N"),
        ([binding("button", command="stop")], "button N or axis N"),
        ([binding("button 1")], "a command where does is command"),
        ([binding("button 1", "talk", "stop")], "a command where does is command"),
        ([binding("axis 1", command="stop", above=0.0)], "another number than 0"),
        (2 * [binding("button 1", command="stop")], "each input once"),
        ([binding("button 1", "talk"), binding("button 2", "mute")], "at most one"),
        ([binding("button 1", "dead_man"), binding("button 2", "dead_man")], "at most one"),
        ([binding("button 1", "jump")], "dead_man"),
        ([], "1"),
    ],
)
def test_settings_that_make_no_sense_are_refused(bindings, words):
    with pytest.raises((ConfigError, CommandsError), match=words):
        pedal_config({**FILE, "bindings": bindings})
    with pytest.raises((ConfigError, CommandsError), match="a name, as source is evdev"):
        pedal_config({**FILE, "source": "evdev"})


STOP_AND_WAKE = (binding("button 0", command="stop"), binding("button 1", command="hey robot"))


@pytest.mark.parametrize("order", [("button 0", "button 1"), ("button 1", "button 0")])
def test_a_command_that_comes_with_a_stop_is_not_to_be_sent(order):
    pedals = make(*STOP_AND_WAKE)
    pedals.take(dict.fromkeys(order, 0.0))
    actions = pedals.take(dict.fromkeys(order, 1.0))
    wake = Send("hey robot", "button 1", "a stop came with it")
    assert set(actions) == {Send("stop", "button 0"), wake} and len(actions) == 2


@pytest.mark.parametrize("stops", ["stop", "dead-man", "loss", "lost events"])
@pytest.mark.parametrize(("later", "is_sent"), [(0.005, False), (0.29, False), (0.5, True)])
def test_a_command_counts_only_a_while_after_a_stop_of_any_kind(stops, later, is_sent):
    now = [10.0]
    held = binding("button 3", "dead_man")
    pedals = make(*STOP_AND_WAKE, held, clock=lambda: now[0])
    for value in (0.0, 1.0):
        pedals.take({"button 0": 0.0, "button 1": 0.0, "button 3": value})
    now[0] += 1.0
    actions = {
        "stop": lambda: press(pedals, "button 0"),
        "dead-man": lambda: press(pedals, "button 3", 0.0),
        "loss": lambda: pedals.lost("unplugged"),
        "lost events": lambda: pedals.events_lost("full"),
    }[stops]()
    assert len(actions) == 1
    if not pedals.is_there:
        pedals.found()
        press(pedals, "button 1", 0.0)
        later = max(later, 0.06)  # a clear release
    now[0] += later
    (sent,) = press(pedals, "button 1")
    assert (sent.command, sent.why_not == "") == ("hey robot", is_sent)
    assert press(pedals, "button 0", 0.0) == ()
    assert press(pedals, "button 0") == (Send("stop", "button 0"),)


def test_lost_events_stop_only_where_a_stop_or_a_held_dead_man_may_be_among_them():
    pedals = make(binding("button 1", command="hey robot"))
    assert pedals.events_lost("full") == () and not pedals.is_there
    (brake,) = make(*STOP_AND_WAKE).events_lost("full")
    assert brake == Brake("full; a stop may have been among them")
