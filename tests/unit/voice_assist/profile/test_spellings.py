# SPDX-License-Identifier: BSD-3-Clause
"""Phrases that the recogniser cannot write become commands by what it writes instead."""

from dataclasses import replace

import pytest

from tests.unit.voice_assist.support.fake_pipeline import decisions, hear
from tests.unit.voice_assist.support.fake_speech import FakeRecognizer, say
from tests.unit.voice_assist.support.records import altered
from typed_config import load_config, load_yaml
from voice_assist.config import CONFIG_DIR, CommandsConfig, load_voice_config
from voice_assist.errors import VoiceError
from voice_assist.intent.confusability import closest_pairs
from voice_assist.intent.mapper import Mapper
from voice_assist.profile import spellings
from voice_assist.profile.manifest import to_bytes
from voice_assist.profile.spellings import (
    MAX_SPELLINGS,
    hear_spellings,
    learn_spellings,
    overlay,
)
from voice_assist.types import Call, Match, NoMatch

ENDOSCOPE = load_config(CommandsConfig, load_yaml(CONFIG_DIR / "endoscope_commands.yaml"))
GERMAN = load_config(CommandsConfig, load_yaml(CONFIG_DIR / "commands_de.yaml"))


def learn(**written):
    return learn_spellings({k.replace("_", " "): v for k, v in written.items()}, GERMAN)


def learned(**written):
    return {s.phrase: s.learned for s in learn(**written)[0].commands}


def why(**written):
    return [refused.why for refused in learn(**written)[1]]


def test_the_example_of_an_endoscope_holds_together_and_no_two_commands_are_too_alike():
    pairs = closest_pairs(ENDOSCOPE, "en-us")
    assert "too alike" not in {p.verdict for p in pairs}, pairs[0].words
    halts = [c.phrase for c in ENDOSCOPE.commands if c.is_halt]
    assert "stop" in halts  # also for the spotter
    replace(load_voice_config(), commands=ENDOSCOPE)
    calls = {c.command for c in ENDOSCOPE.commands}
    assert {"hey robot", "stop", "terminate"} < calls
    assert len([c for c in calls if c.startswith("look ")]) == 10


def test_what_was_written_most_becomes_a_spelling():
    takes = ["mere see", "makes in", "makes in", "Makes in!", "makes in"]
    assert learned(mehr_ziehen=takes) == {"mehr ziehen": ("makes in",)}


def test_a_long_text_counts_when_written_once_and_a_short_one_when_written_twice():
    assert learned(weniger_ziehen=["very desiring"]) == {"weniger ziehen": ("very desiring",)}
    assert "8 letters" in why(halt=["hold"])[0]
    assert learned(halt=["hold", "hold"]) == {"halt": ("hold",)}


def test_what_was_written_for_two_commands_belongs_to_none():
    found, refused = learn(gewebe_spannen=["stand by us"] * 2, jetzt_loslassen=["stand by us"] * 2)
    assert found.commands == () and len(refused) == 2
    assert "it was written for 'gewebe spannen', too" in refused[1].why


def test_what_belongs_to_another_command_or_sounds_too_much_like_it_is_refused():
    (reason,) = why(gewebe_spannen=["stop"] * 3)
    assert "'stop'" in reason
    assert learned(gewebe_spannen=["stop"] * 3, stop=["stop"]) == {}
    (reason,) = why(gewebe_spannen=["sits ung bay enden"] * 2)
    assert "too alike" in reason and "sitzung beenden" in reason


def test_a_spelling_of_a_motion_never_denies():
    assert "denies" in why(mehr_ziehen=["do not see them"] * 2)[0]


def test_nothing_is_learned_of_silence_or_of_what_is_right_already():
    assert learned(gewebe_spannen=["", "", "gewebe spannen", "Gewebe spannen."]) == {}


def test_only_the_most_frequent_are_kept():
    texts = [f"{word} and the rest" for word in ("one", "owl", "red", "sky", "toy", "fur", "gym")]
    found, refused = learn(gewebe_spannen=texts)
    assert len(found.commands[0].learned) == MAX_SPELLINGS and "more frequent" in refused[0].why


def test_the_profile_keeps_them_and_they_are_laid_over_the_commands():
    found, _ = learn(mehr_ziehen=["makes in"] * 2)
    again = spellings.from_bytes(to_bytes(found))
    commands = overlay(GERMAN, again)
    assert again == found and Mapper(commands)("Makes in.").command == "mehr ziehen"
    assert isinstance(Mapper(GERMAN)("makes in"), NoMatch)
    for text in ("makes", "it makes in the end", "makes out", "do not makes in"):
        assert isinstance(Mapper(commands)(text), NoMatch), text


def test_a_damaged_file_of_spellings_is_refused():
    for data in (b"", b"{}", b'{"commands": [{"phrase": "x"}]}', b"[" * 9000):
        with pytest.raises(VoiceError, match="spellings"):
            spellings.from_bytes(data)


def test_what_was_learned_for_a_command_that_is_gone_is_left_out():
    found, _ = learn(mehr_ziehen=["makes in"] * 2)
    others = replace(GERMAN, commands=[c for c in GERMAN.commands if c.phrase != "mehr ziehen"])
    assert overlay(others, found).phrases == others.phrases


@pytest.mark.parametrize("more", [(), (("clamp", "mumble more"),)])  # of no command any more
def test_spellings_are_learned_from_takes(more):
    said = [("tense", "mumble please"), ("release", "release"), *more] * 2
    takes = [(phrase, say(text)) for phrase, text in said]
    commands = load_voice_config().commands
    found, refused = hear_spellings(takes, FakeRecognizer(), commands)
    assert refused == ()
    assert [(s.phrase, s.learned) for s in found.commands] == [("tense", ("mumble please",))]


# In the pipeline: the recogniser hears tones, of which "mumble more" is one that nobody named.


def decide(text, recognizer=None, **learned):
    config, changes = load_voice_config(), {name: {"learned": s} for name, s in learned.items()}
    config = replace(config, commands=altered(config.commands, **changes))
    return decisions(hear(text, recognizer=recognizer, config=config))


def test_a_learned_spelling_moves_and_nothing_like_it_does():
    (decision,) = decide("mumble please", tense=("mumble please",))
    assert isinstance(decision.outcome, Match) and decision.outcome.command == "tense"
    assert decision.actions == (Call("tense"),)
    for text in ("mumble", "do not mumble please", "mumble please what he said"):
        for decision in decide(text, tense=("mumble please",)):
            assert isinstance(decision.outcome, NoMatch) and not decision.actions, text
    assert all(isinstance(d.outcome, NoMatch) for d in decide("mumble please"))


def test_the_second_opinion_scores_what_was_written_and_may_refuse_it():
    scores = {"mumble please": -30.0, "tense": -40.0, "release": 0.0}
    (decision,) = decide("mumble please", FakeRecognizer(scores), tense=("mumble please",))
    assert isinstance(decision.outcome, NoMatch)
    assert "sounds more like 'release'" in decision.outcome.rejection.words
