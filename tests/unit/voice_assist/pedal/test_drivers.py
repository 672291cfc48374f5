# SPDX-License-Identifier: BSD-3-Clause
"""Several drivers on one topic: whose news of an input count while another one holds it."""

import pytest

from typed_config import load_yaml
from voice_assist.config import CONFIG_DIR
from voice_assist.config.pedal import pedal_config
from voice_assist.pedal.drivers import Drivers
from voice_assist.pedal.pedals import Pedals

FILE = load_yaml(CONFIG_DIR / "pedal.yaml")
COMMAND = {"input": "axis 0", "above": 0.5, "does": "command", "command": "pull more"}


class Foot:
    """Pedals with one binding, and drivers that a test makes deaf."""

    def __init__(self, **changes):
        config = pedal_config({**FILE, "bindings": [COMMAND | changes]})
        self.now, self.lost = 0.0, set()
        self.pedals = Pedals(config, lambda: self.now)
        self.pedals.found()
        self.drivers = Drivers(config, self.pedals, lambda name: name not in self.lost)

    def take(self, driver, value):
        """Gives how many actions follow."""
        self.now += 1.0
        return len(self.pedals.take(self.drivers.counting(driver, {"axis 0": value})))

    def say(self, *news):
        return [self.take(driver, value) for driver, value in news]


def test_where_two_hold_an_input_the_release_of_one_is_no_new_press_of_the_other():
    foot = Foot()
    assert foot.say(("a", 0.0), ("b", 0.0), ("a", 1.0), ("b", 1.0)) == [0, 0, 1, 0]
    assert foot.say(("a", 0.0), ("b", 1.0), ("a", 0.0), ("b", 1.0)) == [0, 0, 0, 0]
    assert foot.say(("b", 0.0), ("b", 1.0)) == [0, 1]


def test_where_two_hold_a_dead_man_the_release_of_either_brakes():
    foot = Foot(does="dead_man", command="")
    foot.say(("a", 0.0), ("a", 1.0), ("b", 1.0))
    assert foot.say(("a", 0.0), ("b", 1.0)) == [1, 0]
    assert not foot.pedals.is_held  # until one of them presses it anew
    foot.say(("a", 1.0))
    assert foot.pedals.is_held


def test_where_two_hold_mute_voice_counts_once_both_have_released_it():
    foot = Foot(does="mute", command="")
    seen = []
    for news in (("a", 1.0), ("b", 1.0), ("a", 0.0), ("b", 1.0), ("b", 0.0)):
        foot.say(news)
        seen.append(foot.pedals.may_talk)
    assert seen == [False, False, False, False, True]


@pytest.mark.parametrize(("does", "may_talk"), [("talk", True), ("mute", False)])
def test_a_gate_stays_as_its_driver_holds_it_beside_one_at_rest(does, may_talk):
    foot = Foot(does=does, command="")
    foot.say(("a", 0.0), ("a", 1.0), ("b", 0.0))
    assert foot.pedals.may_talk is may_talk
    foot.lost.add("a")
    foot.say(("b", 0.0))
    assert foot.pedals.may_talk is not may_talk


def test_a_stop_of_one_driver_counts_while_another_one_holds_it():
    foot = Foot(command="stop")
    assert foot.say(("a", 1.0), ("b", 0.0), ("b", 1.0)) == [1, 0, 1]


def test_what_is_held_from_the_start_presses_nothing_beside_a_driver_at_rest():
    foot = Foot()
    assert foot.say(("a", 1.0), ("b", 0.0), ("a", 1.0), ("b", 0.0)) == [0] * 4
    assert foot.say(("a", 0.0), ("a", 1.0)) == [0, 1]


def test_a_driver_that_was_lost_while_it_held_an_input_presses_after_its_own_release():
    foot = Foot()
    foot.say(("a", 0.0), ("a", 1.0))
    foot.lost.add("a")
    foot.say(("b", 0.0))
    foot.lost.clear()
    assert foot.say(("a", 1.0), ("a", 0.0), ("a", 1.0)) == [0, 0, 1]


def test_inputs_that_nobody_bound_pass():
    foot = Foot()
    assert foot.drivers.counting("a", {"button 9": 1.0}) == {"button 9": 1.0}
