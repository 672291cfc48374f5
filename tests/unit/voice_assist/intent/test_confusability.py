# SPDX-License-Identifier: BSD-3-Clause
"""Phrases that are too alike are found before anybody relies on them."""

import pytest

from tests.unit.voice_assist.support.records import altered, command_entries
from voice_assist.cli.main import main
from voice_assist.config import CONFIG_DIR, load_voice_config
from voice_assist.intent.confusability import ALIKE, TOO_ALIKE, closest_pairs, nearest, objection
from voice_assist.text import phonetic_distance as pronunciation
from voice_assist.text.phonetic_distance import (
    can_pronounce,
    difference,
    distance,
    languages,
    sounds,
    sounds_of_letters,
)

COMMANDS = load_voice_config().commands
# Near misses that the recogniser took for a command in at least one synthetic voice.
TAKEN = ("pool more", "pull moor", "tens", "re lease", "relief", "stops", "top", "hey robert")
OTHERS = ("insert", "withdraw", "camera left", "zoom", "scissors", "suction", "photo", "lights on")

both = pytest.mark.parametrize("is_pronounced", [True, False])


@pytest.fixture
def pronounced(is_pronounced, monkeypatch):
    if is_pronounced and not can_pronounce():
        pytest.skip("espeak-ng is not installed")
    if not is_pronounced:
        monkeypatch.setattr(pronunciation, "which", lambda program: None)
    sounds.cache_clear()
    yield is_pronounced
    sounds.cache_clear()


@both
def test_the_seven_commands_are_apart(pronounced):
    pairs = closest_pairs(COMMANDS)
    assert len(pairs) == 21 and {p.verdict for p in pairs} == {"apart"}
    assert min(p.sound for p in pairs) > ALIKE


@both
@pytest.mark.parametrize("text", TAKEN)
def test_what_was_taken_for_a_command_is_warned_of(pronounced, text):
    assert nearest(text, COMMANDS).verdict != "apart"


@both
@pytest.mark.parametrize("text", OTHERS)
def test_what_is_quite_different_is_not(pronounced, text):
    assert nearest(text, COMMANDS).verdict == "apart" and objection(text, COMMANDS) == ""


@both
def test_an_objection_names_both_phrases_and_the_limit(pronounced):
    words = objection("pool more", COMMANDS)
    assert "'pool more' and 'pull more'" in words and f"{TOO_ALIKE:.2f}" in words


def test_a_spelling_may_be_like_the_command_that_it_belongs_to():
    assert objection("pool more", COMMANDS, own="pull more") == ""
    assert objection("pool less", COMMANDS, own="pull more")


def test_spellings_count_as_much_as_phrases():
    (first, *_) = closest_pairs(altered(COMMANDS, tense={"spellings": ("re leash",)}))
    assert {first.one, first.other} == {"tense", "release"} and first.verdict != "apart"
    assert first.spellings == ("re leash", "release")


def test_a_distance_is_one_at_most_and_the_same_both_ways():
    rows = [sounds_of_letters(t) for t in ("stop", "pull more", "terminate", "a", "xylophone")]
    for a in rows:
        assert distance(a, a) == 0.0
        for b in rows:
            assert distance(a, b) == pytest.approx(distance(b, a)) and 0.0 <= distance(a, b) <= 1.0
    assert distance((), ()) == 0.0 and distance(rows[0], ()) == 1.0


def test_similar_sounds_are_nearer_than_others():
    assert difference("p", "b") < difference("p", "s") <= difference("p", "a") == 1.0
    assert difference("ʊ", "u") < difference("i", "ɑ")


def test_letters_stand_for_sounds_where_nothing_pronounces():
    assert sounds_of_letters("tense") == ("t", "ɛ", "n", "s")
    assert sounds_of_letters("") == () == sounds_of_letters("123")


@pytest.mark.parametrize("program", ["exit 1", "exec sleep 60", "true"])
def test_letters_stand_for_sounds_where_espeak_fails_hangs_or_says_nothing(
    program, tmp_path, monkeypatch
):
    (path := tmp_path / "espeak-ng").write_text(f"#!/bin/sh\n{program}\n")
    path.chmod(0o700)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    monkeypatch.setattr(pronunciation, "_PATIENCE", 0.2)
    assert sounds.__wrapped__("tense") == sounds_of_letters("tense")
    assert languages.__wrapped__() == ()


def test_the_command_line_shows_the_nearest_pairs(capsys):
    main(["check-commands"])
    said = capsys.readouterr().out
    assert "'pull more' and 'pull less'" in said and "0 too alike" in said


def test_the_command_line_fails_for_a_file_with_two_that_are_too_alike(tmp_path, capsys):
    text = (CONFIG_DIR / "commands.yaml").read_text()
    (path := tmp_path / "c.yaml").write_text(text.replace("phrase: terminate", "phrase: dense"))
    with pytest.raises(SystemExit) as ended:
        main(["check-commands", str(path)])
    assert ended.value.code == 1
    assert "too alike" in capsys.readouterr().out


@pytest.mark.skipif(not can_pronounce(), reason="espeak-ng is not installed")
@pytest.mark.parametrize(("asked", "near"), [("en-uk", "en-"), ("klingon", "such as ")])
def test_a_language_that_nothing_pronounces_is_refused_with_one_that_is_known(capsys, asked, near):
    with pytest.raises(SystemExit) as ended:
        main(["check-commands", "--language", asked])
    said = capsys.readouterr()
    assert (ended.value.code, said.out) == (2, "")
    assert f"--language is {asked!r}, allowed: a language of" in said.err and near in said.err


@pytest.mark.parametrize("language", ["en-us", "de", "es"])
def test_languages_of_the_documents_are_known(language):
    assert not can_pronounce() or language in languages()


def test_where_nothing_pronounces_any_language_is_guessed_and_said_so(monkeypatch, capsys):
    monkeypatch.setattr(pronunciation, "which", lambda _: None)
    languages.cache_clear()
    main(["check-commands", "--language", "klingon"])
    languages.cache_clear()
    assert "sounds are guessed from letters" in capsys.readouterr().out


def test_numbers_of_a_slot_are_compared_by_their_own_words():
    config = load_voice_config(commands__amounts=True)
    slot = {**vars(config.commands.slots[0]), "values": [2.0, 10.0, 15.0, 50.0]}
    entries = command_entries()
    entries.append({**entries[3], "phrase": "pull {distance} onwards", "threshold": 0.1})
    changes = {"commands__slots": [slot], "commands__commands": entries}
    found = load_voice_config(commands__amounts=True, **changes).commands
    pairs = {pair.spellings: pair.verdict for pair in closest_pairs(found)}
    assert pairs["two", "ten"] == "apart"
    assert pairs["fifteen", "fifty"] == "too alike"
    assert pairs["pull millimetres onwards", "pull more"] == "apart"
    assert not any("two millimetres" in text for pair in pairs for text in pair)
