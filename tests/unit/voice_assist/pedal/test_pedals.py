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


def make(*bindings, there=True):
    pedals = Pedals(pedal_config({**FILE, "bindings": list(bindings)}))
    if there:
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
