# SPDX-License-Identifier: BSD-3-Clause
"""Optional words and slots of commands.yaml."""

import pytest

from tests.unit.voice_assist.support.records import command_entries
from voice_assist.config import load_voice_config
from voice_assist.config.commands import AmountCommand
from voice_assist.config.spelling_grammar import without_brackets
from voice_assist.errors import CommandsError
from voice_assist.text.normalize import normalize

COMMANDS = load_voice_config(commands__amounts=True).commands


def entry(**changes):
    plain = load_voice_config().commands.get("pull more")
    return {**vars(plain), "spellings": [], "threshold": 0.1, "learned": [], **changes}


def loaded(*entries, **slot):
    commands = [*command_entries(), *entries]
    way = {"name": "way", "unit": "mm", "values": [1.0, 2.0], "ask_above": 1.0, "needs_unit": True}
    changes = {"commands__slots": [{**way, **slot}], "commands__commands": commands}
    return load_voice_config(commands__amounts=True, **changes).commands


@pytest.mark.parametrize(
    ("spelling", "texts"),
    [
        ("stop", ("stop",)),
        ("[please] stop [now]", ("stop", "stop now", "please stop", "please stop now")),
        ("stop stop [stop] [stop]", ("stop stop", "stop stop stop", "stop stop stop stop")),
        ("[very well] stop", ("stop", "very well stop")),
    ],
)
def test_optional_words_are_written_out(spelling, texts):
    assert without_brackets("spellings[0]", spelling) == texts


@pytest.mark.parametrize("spelling", ["[please stop", "please] stop", "[[please] stop]", "{stop"])
def test_brackets_that_do_not_match_are_named(spelling):
    with pytest.raises(CommandsError, match=r"spellings\[0\] is .* matching brackets"):
        loaded(entry(phrase="pull {way} on", spellings=[spelling]))


def test_a_phrase_with_a_slot_is_one_command_per_amount():
    made = {c.phrase: c.command for c in COMMANDS.commands if isinstance(c, AmountCommand)}
    assert made["pull half a millimetre more"] == "pull more 0.5 mm"
    assert made["half a newton less"] == "pull less 0.5 N"
    assert made["tension one point five"] == "tense 1.5 N"
    assert len(made) == len(set(made.values())) == 17
    assert not any(phrase in made for phrase in COMMANDS.fixed_phrases)
    assert load_voice_config().commands.phrases == COMMANDS.fixed_phrases  # unless switched on


def test_a_whole_number_without_a_unit_has_a_point():
    _, spellings = zip(*COMMANDS.get("tension two newtons").all_spellings, strict=True)
    assert spellings == ("tension two newtons", "tension two point zero")


def test_optional_words_and_a_slot_may_stand_together():
    found = loaded(entry(phrase="pull {way} on", spellings=["[please] pull on {way}"]))
    spellings = found.get("pull two millimetres on").spellings
    assert spellings == ("pull on two millimetres", "please pull on two millimetres")


@pytest.mark.parametrize(
    ("changes", "slot", "said"),
    [
        ({"phrase": "pull {far} on"}, {}, "'pull {far} on', allowed: at most one of {way}"),
        ({"phrase": "pull {way} {way}"}, {}, "at most one of {way}"),
        ({"phrase": "pull {way} on", "spellings": ["pull on"]}, {}, "text with {way}"),
        ({"phrase": "pull on", "spellings": ["pull {way} on"]}, {}, "text without a slot"),
        ({"phrase": "[please] pull on"}, {}, "without [optional] words"),
        ({"phrase": "pull {way} on"}, {"values": []}, "one number or more"),
        ({"phrase": "pull {way} on"}, {"values": [2.0, 2.0]}, "each once"),
        ({"phrase": "pull {way} on"}, {"values": [1.9999]}, "at most 3 decimals"),
        ({"phrase": "pull {way} on"}, {"values": [0.5, 5.0]}, "'five' is of 'point five'"),
        ({"phrase": "pull {way} on"}, {"values": [2.0, 22.0]}, "'two' is of 'twenty two'"),
        ({"phrase": "pull {way} on"}, {"values": [0.0]}, "a number from 0.001"),
        ({"phrase": "pull {way} on"}, {"unit": "inch"}, "one of mm, N"),
        ({"phrase": "pull {way} more", "threshold": 0.5}, {}, None),
        ({"phrase": "turn {way}", "is_motion": False, "command": ""}, {}, "takes an amount"),
    ],
)
def test_what_a_slot_may_not_be_is_named(changes, slot, said):
    if said is None:
        assert loaded(entry(**changes), **slot).get("pull two millimetres more")
        return
    with pytest.raises(ValueError, match="allowed") as error:
        loaded(entry(**changes), **slot)
    assert said in str(error.value)


def test_two_commands_that_differ_in_one_word_beside_the_same_amount_are_still_kept_apart():
    ways = [entry(phrase=f"pull {{way}} {word}", threshold=0.5) for word in ("on", "off")]
    with pytest.raises(CommandsError, match=r"its WER 0.25 is below the threshold of 'pull one"):
        loaded(*ways)


def test_an_amount_is_scored_beside_every_other_number_written_the_same():
    texts = COMMANDS.scored("pull two millimetres more", normalize("Pull 2mm more."))
    assert texts["pull two millimetres more"] == "pull two mm more"
    assert texts["pull three millimetres more"] == "pull three mm more"
    assert texts["pull half a millimetre more"] == "pull half a mm more"
    assert texts["pull two millimetres less"] == "pull two millimetres less"
    assert texts["stop"] == "stop" and "half a newton less" not in texts
    assert set(COMMANDS.scored("pull more", ("pull", "more"))) == set(COMMANDS.fixed_phrases)
