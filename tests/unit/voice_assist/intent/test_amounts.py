# SPDX-License-Identifier: BSD-3-Clause
"""A number is taken as it was heard, with its unit, or refused by name."""

import pytest

from tests.unit.voice_assist.support.records import command_entries
from typed_config import load_config, load_yaml
from voice_assist.config import CONFIG_DIR, CommandsConfig, load_voice_config
from voice_assist.intent.mapper import Mapper
from voice_assist.types import Match, NoMatch

MAPPER = Mapper(load_voice_config(commands__amounts=True).commands)
PLAIN = Mapper(load_voice_config().commands)


@pytest.mark.parametrize(
    ("text", "command"),
    [
        ("pull two millimetres more", "pull two millimetres more"),
        ("Pull 2 millimeters more.", "pull two millimetres more"),
        ("pull 0.5 mm less", "pull half a millimetre less"),
        ("Half a Newton less.", "half a newton less"),
        ("0.2 N more", "point two newtons more"),
        ("Tension 1.5", "tension one point five"),
        ("tension one point five newtons", "tension one point five"),
        ("tension two point zero", "tension two newtons"),
        ("pull more", "pull more"),
    ],
)
def test_an_amount_is_taken_in_any_of_its_wordings(text, command):
    outcome = MAPPER(text)
    assert isinstance(outcome, Match) and outcome.command == command


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("pull nine millimetres more", "'nine millimetres' is not among its amounts"),
        ("pull twenty two millimetres more", "'twenty two millimetres' is not among"),
        ("pull one point two millimetres more", "'one point two millimetres' is not among"),
        ("pull two and a half millimetres more", "'two point five millimetres' is not among"),
        ("pull two newtons more", "'two newtons' is not among its amounts"),
        ("pull two metres more", "'two metres' is not among its amounts"),
        ("pull two more", "'two' has no unit"),
        ("tension one", "'one' has no unit"),
        ("tension one point nine", "'one point nine' is not among its amounts"),
        ("pull one point five more", "'one point five' has no unit"),
        ("pull millimetres more", "'millimetres' has no number"),
        ("newton less", "'newton' has no number"),
        ("pull more two millimetres", "'two millimetres' stands in another place"),
        ("pull two more millimetres", "'two millimetres' stands in another place"),
        ("pull more nine millimetres", "'nine millimetres' is not among its amounts"),
        ("two millimetres more", "'two millimetres' is not among its amounts: '{step} more'"),
    ],
)
def test_a_wrong_amount_is_refused_by_name(text, why):
    outcome = MAPPER(text)
    assert isinstance(outcome, NoMatch) and outcome.rejection.words.startswith(why)
    assert "takes " in outcome.rejection.words  # and what was allowed


@pytest.mark.parametrize(
    "text",
    [
        "pull two millimetres",
        "two millimetres more",
        "pull not two millimetres more",
        "do not pull two millimetres more",
        "he said pull two millimetres more",
        "pull two millimetres more or less",
        "minus two newtons more",
        "pull minus two millimetres more",
        "pull two two millimetres more",
        "pull a couple of millimetres more",
        "pull half more",
        "pull ½ mm more",
        *("we should stop", "do not stop", "two men stop", "pull it stop"),  # no stop either
    ],
)
def test_what_is_only_like_an_amount_does_nothing(text):
    assert isinstance(MAPPER(text), NoMatch)


def test_no_threshold_forgives_a_number_or_a_unit():
    config = load_voice_config(commands__amounts=True)
    entries = command_entries()
    loose = {**entries[3], "phrase": "pull {distance} onwards now", "threshold": 0.5}
    slots = [vars(slot) | {"values": [2.0]} for slot in config.commands.slots[:1]]
    changes = {"commands__slots": slots, "commands__commands": [*entries, loose]}
    mapper = Mapper(load_voice_config(commands__amounts=True, **changes).commands)
    assert mapper("full two millimetres onward now").command == "pull two millimetres onwards now"
    for wrong in ("ten millimetres", "two newtons", "millimetres", "two", "twelve millimetres"):
        assert isinstance(mapper(f"pull {wrong} onwards now"), NoMatch), wrong


@pytest.mark.parametrize(
    "text",
    [
        "pull two stop",
        "pull nine millimetres stop",
        "tension one point stop",
        "pull to stop",
        "half a stop",
    ],
)
def test_a_stop_within_an_amount_stops(text):
    outcome = MAPPER(text)
    assert isinstance(outcome, Match) and outcome.command == "stop"
    assert not MAPPER.cannot_become(f"{text} ") and not MAPPER.cannot_become(text)


def test_a_spelling_of_a_halt_within_an_amount_stops_too():
    data = load_yaml(CONFIG_DIR / "commands.yaml")
    for command in data["commands"]:
        if command["is_halt"]:
            command["spellings"].append("freeze")
    mapper = Mapper(load_config(CommandsConfig, {**data, "amounts": True}))
    outcome = mapper("pull two freeze")
    assert isinstance(outcome, Match) and outcome.command == "stop"
    assert isinstance(mapper("we should freeze"), NoMatch)


def test_a_number_that_goes_on_is_waited_for():
    assert not MAPPER.can_grow("pull two millimetres more")
    for beginning in ("pull zero ", "pull 0. ", "tension one ", "pull twenty "):
        assert not MAPPER.cannot_become(beginning), beginning
    assert MAPPER.cannot_become("the patient needs two millimetres ")


@pytest.mark.parametrize(
    "text", ["pull two millimetres more", "tension one point five", "pull two stop"]
)
def test_switched_off_no_amount_is_taken(text):
    assert isinstance(PLAIN(text), NoMatch)
