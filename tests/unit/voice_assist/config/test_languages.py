# SPDX-License-Identifier: BSD-3-Clause
"""Commands, answers, alarms and page in other languages: files that hold together, and refusals."""

import re
from dataclasses import replace
from itertools import islice
from pathlib import Path

import pytest

from tests.unit.voice_assist.support.records import altered
from typed_config import ConfigError, load_config, load_yaml
from voice_assist.alarms import causes, presenter
from voice_assist.alarms.types import ControllerEvent
from voice_assist.answers.sentences import catalogue
from voice_assist.answers.word_check import WordCheck
from voice_assist.cli.main import main
from voice_assist.config import CONFIG_DIR, CommandsConfig, load_voice_config
from voice_assist.config.commands import LANGUAGES
from voice_assist.config.texts import TEXTS_DIR, page_texts, texts_of
from voice_assist.display.server import PAGE
from voice_assist.errors import CommandsError, ModelError
from voice_assist.intent.confusability import closest_pairs
from voice_assist.intent.mapper import Mapper
from voice_assist.text.phonetic_distance import can_pronounce, espeak_language
from voice_assist.types import NoMatch

OTHERS = LANGUAGES[1:]
ENGLISH = load_voice_config().commands
each_language = pytest.mark.parametrize("language", OTHERS)
needs_sounds = pytest.mark.skipif(not can_pronounce(), reason="espeak-ng is not installed")


def commands_in(language):
    return load_voice_config(language=language).commands


def next_steps():
    tables = causes.LATCHES, causes.GIVE_UPS, causes.REFUSALS, causes.UNHEARD, causes.PARTS
    steps = {advice.next_step for table in tables for advice in table.values()}
    commands = ("tense", presenter.HEY_ROBOT, presenter.TERMINATE)
    taken = (presenter.event_alarm(ControllerEvent("accepted", c, ""), False) for c in commands)
    others = causes.UNKNOWN, causes.NO_REASON, *taken
    return steps | {advice.next_step for advice in others}


def page_keys():
    """Texts of page.js as its function `t` looks them up, those of its tables, and of the HTML."""
    script = (PAGE / "page.js").read_text("utf-8")
    keys = set()
    for begin in re.finditer(r"\bt`", script):
        text, depth, at, values = "", 0, begin.end(), 0
        while script[at] != "`" or depth:
            if script.startswith("${", at):
                text += f"{{{values}}}" if not depth else ""
                values, depth, at = values + (not depth), depth + 1, at + 2
                continue
            depth -= script[at] == "}" and depth > 0
            text += script[at] if not depth and script[at] != "}" else ""
            at += 1
        keys.add(text)
    for table in re.findall(r"const (?:NAMES|PHASES) = \{(.*?)\};", script, re.DOTALL):
        keys.update(re.findall(r': "([^"]+)"', table))
    page = re.sub(r"<!--.*?-->", "", (PAGE / "index.html").read_text("utf-8"), flags=re.DOTALL)
    keys.update(re.findall(r'(?:aria-label|alt)="([^"]+)"', page))
    body = page[page.index("<main>") :]
    return keys | {t.strip() for t in re.findall(r">([^<>]+)<", body) if t.strip()}


@each_language
def test_the_seven_commands_are_there_and_every_spelling_is_heard(language):
    commands = commands_in(language)
    assert commands.language == language
    assert {c.command for c in commands.commands} == {c.command for c in ENGLISH.commands}
    mapper = Mapper(commands)
    for command in commands.commands:
        for _, text in command.all_spellings:
            assert mapper(f"{text[:1].upper()}{text[1:]}!").command == command.phrase


@each_language
def test_the_native_stop_word_stops_and_so_does_the_english_one(language):
    halts = [c.phrase for c in commands_in(language).commands if c.is_halt]
    assert halts[0] == "stop" and len(halts) > 1
    assert Mapper(commands_in(language))("Stop.").command == "stop"


@needs_sounds
@each_language
def test_no_two_commands_are_too_alike_in_the_sounds_of_the_language(language, capsys):
    pairs = closest_pairs(commands_in(language), espeak_language(language))
    assert "too alike" not in {pair.verdict for pair in pairs}, pairs[0].words
    main(["check-commands", str(CONFIG_DIR / f"commands_{language}.yaml")])
    assert "0 too alike" in capsys.readouterr().out  # the file says its language itself


@each_language
def test_every_sentence_of_answers_alarms_and_page_is_in_the_catalogue_and_no_other(language):
    found = load_yaml(TEXTS_DIR / f"{language}.yaml")
    assert set(found["answers"]) == set(catalogue())
    assert set(found["alarms"]) == next_steps()
    rest = {"voice", "unknown", "standby", "active"}  # values of the snapshot
    assert set(found["page"]) - rest == page_keys() - rest
    assert page_texts(language) == found["page"] and page_texts("en") == {}
    for section in found.values():
        for english, text in section.items():
            assert sorted(re.findall(r"\{\d\}", text)) == sorted(re.findall(r"\{\d\}", english))


@each_language
def test_an_alarm_names_the_phrases_that_can_be_said(language):
    commands = commands_in(language)
    phrases = [c.phrase for c in commands.commands]
    texts = texts_of(commands)
    for step in next_steps():
        said = texts(step)
        assert "{" not in said
        quoted = [w for w in re.findall(r'"([^"]+)"', step) if w not in ("yes", "insert")]
        assert len([p for p in phrases if p in said]) >= len(set(quoted)) > 0 or not quoted


def test_an_alarm_in_another_language_keeps_its_details():
    alarm = presenter.latch_alarm("tension 2.50 N, allowed 2.40 N", "over_tension", True)
    said = alarm.said_in(texts_of(commands_in("de")))
    assert said.cause == "zu viel Kraft: tension 2.50 N, allowed 2.40 N"
    assert said.next_step == "„hallo roboter“ sagen, dann „jetzt loslassen“."
    assert alarm.said_in(texts_of(ENGLISH)) == alarm


def test_an_english_alarm_names_renamed_phrases_too():
    wakes = {"phrase": "wake up now", "spellings": ()}
    opens = {"phrase": "let it go", "spellings": ()}
    texts = texts_of(altered(ENGLISH, hey_robot=wakes, release=opens))
    assert texts('Say "hey robot", then "release".') == 'Say "wake up now", then "let it go".'
    assert texts('Say "yes" if it is what you said.') == 'Say "yes" if it is what you said.'


def test_a_command_that_no_phrase_calls_is_named_as_the_robot_knows_it():
    commands = commands_in("de")
    some = tuple(c for c in commands.commands if c.command != "release")
    texts = texts_of(replace(commands, commands=some))
    assert texts('Say "release" first.') == "Zuerst „release“ sagen."


@needs_sounds
@each_language
def test_a_third_of_the_answers_at_least_may_be_said_beside_the_microphone(language):
    commands = commands_in(language)
    check, texts = WordCheck(commands), texts_of(commands)
    third = -(-len(catalogue()) // 3)
    free = (s for s in catalogue() if not check.objection(texts(s)))
    assert len(list(islice(free, third))) == third


@pytest.mark.parametrize("use", [lambda it: load_voice_config(language=it), page_texts])
def test_an_unknown_language_is_refused_with_those_there_are(use):
    with pytest.raises(ConfigError, match="'it', allowed: en, de, es, fr, ja"):
        use("it")


@pytest.mark.parametrize(("language", "is_asking"), [("en", True), ("de", False), ("ja", False)])
def test_a_nearly_sure_motion_is_asked_for_where_none_is_said_twice(language, is_asking):
    assert load_voice_config(language=language).is_asking is is_asking


def test_what_only_english_has_is_refused_by_name():
    with pytest.raises(CommandsError, match=r"ask.is_enabled.*language de"):
        load_voice_config(language="de", commands__said_twice=False)
    with pytest.raises(CommandsError, match="amounts are English words"):
        replace(commands_in("fr"), amounts=True)
    with pytest.raises(CommandsError, match="English, in letters a to z"):
        data = dict(load_yaml(CONFIG_DIR / "commands_es.yaml"), language="en")
        load_config(CommandsConfig, data)


def test_a_phrase_of_kanji_is_refused_since_nothing_gives_its_sounds():
    commands = load_yaml(CONFIG_DIR / "commands_ja.yaml")
    commands["commands"][2]["phrase"] = "組織を離して"
    with pytest.raises(CommandsError, match=r"commands\[2\].phrase.*'組織を離して'.*kana"):
        load_config(CommandsConfig, commands)


def test_what_a_japanese_sentence_may_not_hold():
    check = WordCheck(commands_in("ja"))
    assert "in sound" in check.objection("もっと ひっぱって います")
    assert not check.objection("かんせつの げんかい")


def test_kanji_and_kana_are_taken_for_the_same_command_and_a_denial_for_none():
    mapper = Mapper(commands_in("ja"))
    assert mapper("もっと引っ張って。").command == mapper("もっとひっぱって！").command
    assert isinstance(mapper("もっと ひっぱらないで"), NoMatch)


def test_a_missing_model_names_the_command_that_fetches_it(monkeypatch, tmp_path):
    from voice_assist.assembly import make_recognizer

    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    with pytest.raises(ModelError, match="make languages"):
        make_recognizer(load_voice_config(language="de"))
    assert list(Path(tmp_path).iterdir()) == []  # and nothing was fetched
