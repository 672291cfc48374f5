# SPDX-License-Identifier: BSD-3-Clause
"""A whole enrolment, with few steps, of a voice of espeak-ng that training never used."""

import dataclasses
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.unit.voice_assist.support.records import take as good_take
from voice_assist.config import load_voice_config
from voice_assist.config.enrolment import load_enrolment_config
from voice_assist.enrolment.adapt import Adapted
from voice_assist.enrolment.build import _of_commands as of_commands
from voice_assist.enrolment.build import _require_takes as require_takes
from voice_assist.enrolment.build import build
from voice_assist.enrolment.learn import EnrolmentMaterial, LabelledTake
from voice_assist.enrolment.pipeline_probe import PipelineProbe
from voice_assist.enrolment.self_check import SelfCheckResult
from voice_assist.enrolment.takes.checks import TakeCheck
from voice_assist.enrolment.takes.script import EnrolmentScript, EnrolmentStep
from voice_assist.profile import spellings
from voice_assist.profile.active import PersonalRecognizer, personalise
from voice_assist.profile.manifest import ACTIVE, COMMAND, RECORDING, REFUSED, TALK
from voice_assist.profile.profile import VoiceProfileError, create_profile, open_profile
from voice_assist.training.data.voices import HELD_OUT_ACCENT, Prompt, speak
from voice_assist.types import RATE

pytestmark = [
    pytest.mark.skipif(not shutil.which("espeak-ng"), reason="espeak-ng is not installed"),
    pytest.mark.timeout(1200),  # [s] for a busy machine
]

MODULE = "voice_assist.enrolment.build"
VOICE = f"{HELD_OUT_ACCENT}+Alex"
PHRASES = ("hey robot", "pull more", "pull less", "stop")  # of all commands, to be quick
TALKED = ("where is the trocar", "we are almost done", "thank you")
SPELLED_AS_ANOTHER = b'{"commands": [{"phrase": "pull more", "learned": ["pull less"]}]}'
TALK_NOT_ENROLLED = ("he told me to pull more shifts", "call the ward")


def spoken(text, rate=1.0):
    (sound,) = speak([Prompt(text, "espeak", VOICE, rate, 0.5)])
    assert sound is not None
    quiet = np.random.default_rng(1).normal(0.0, 3e-4, len(sound) + RATE // 2)
    quiet[RATE // 4 : RATE // 4 + len(sound)] += sound / 32768.0
    return quiet.astype(np.float32)


@pytest.fixture(scope="module")
def voice(tmp_path_factory):
    """Without the spotter, which learns nothing, and with few passes of the recogniser."""
    whole = load_voice_config(
        profile__folder=str(tmp_path_factory.mktemp("profiles")),
        spotter__is_enabled=False,
        recognizer__early__partial_interval=0.5,
    )
    some = tuple(c for c in whole.commands.commands if c.phrase in PHRASES)
    return dataclasses.replace(whole, commands=dataclasses.replace(whole.commands, commands=some))


@pytest.fixture(scope="module")
def config():
    whole = load_enrolment_config()
    quick = dataclasses.replace(
        whole.adapt, copies=1, broken_off=1, others=15, steps=4, batch=6, rate=1e-4
    )
    check = dataclasses.replace(whole.self_check, folds=2, others=2)
    return dataclasses.replace(whole, talk=6.0, adapt=quick, self_check=check)


@pytest.fixture(scope="module")
def profile(voice, config, base):
    made = create_profile("ada", base.model_hash, Path(voice.profile.folder))
    check = TakeCheck(config.checks, voice.commands, base)
    session = EnrolmentScript(made, config, voice.commands.phrases, check)
    for rate in (0.9, 1.0, 1.1):
        for phrase in voice.commands.phrases:
            session.offer(EnrolmentStep(COMMAND, phrase, 2.0, 1, 1), spoken(phrase, rate))
    for text in TALKED:
        session.offer(EnrolmentStep(TALK, "", 2.0, 1, 1), spoken(text))
    build(made, voice, config, base)
    return made


def test_a_profile_of_good_takes_is_active_with_report_and_thresholds(profile, voice):
    assert profile.manifest.state == ACTIVE, profile.manifest.why
    report = json.loads(profile.read("report.json"))
    assert report["takes"]["right_by_profile"] >= report["takes"]["right_by_base"]
    assert report["talk"] == {"pieces": 3, "taken_by_base": 0, "taken_by_profile": 0}
    assert [e["phrase"] for e in report["expected"]] == list(voice.commands.phrases)
    assert "Active." in profile.read("report.md").decode()
    assert spellings.from_bytes(profile.read("spellings.json")) is not None
    assert profile.has("voiceprint.npz")


def test_with_the_profile_commands_are_taken_and_talk_does_nothing(profile, voice, base):
    ada = dataclasses.replace(voice.profile, name="ada")
    as_shipped = load_voice_config().recognizer
    active = dataclasses.replace(voice, profile=ada, recognizer=as_shipped)
    personal = personalise(active, base)
    assert isinstance(personal, PersonalRecognizer)
    probe = PipelineProbe(active, personal)
    said = {phrase: probe(spoken(phrase, 1.05)).taken for phrase in voice.commands.phrases}
    assert said == {phrase: (phrase,) for phrase in voice.commands.phrases}
    heard = {text: probe(spoken(text)).taken for text in TALK_NOT_ENROLLED}
    assert heard == dict.fromkeys(heard, ())


@pytest.mark.parametrize("breaks", ["learn", "hear_spellings", "SelfCheck.__call__"])
def test_learning_anew_that_is_broken_off_leaves_an_active_profile_as_it_was(
    profile, voice, config, base, monkeypatch, breaks
):
    def broken_off(*_):
        raise KeyboardInterrupt

    folder, before = profile.folder.parent, profile.manifest_digest
    monkeypatch.setattr(f"{MODULE}.others_for", lambda *_: [])
    monkeypatch.setattr(f"{MODULE}.learn", lambda *_: Adapted({}, 0.0))
    monkeypatch.setattr(f"{MODULE}.{breaks}", broken_off)
    with pytest.raises(KeyboardInterrupt):
        build(open_profile("ada", folder), voice, config, base)
    assert open_profile("ada", folder).manifest_digest == before
    assert profile.manifest.state == ACTIVE


WRONG = ("takes/0001.wav: wrong word",)
FAILED = SelfCheckResult(wrong_words=list(WRONG))


def every_file(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture
def fails(monkeypatch):
    """Whatever is learned fails its check."""
    monkeypatch.setattr(f"{MODULE}.others_for", lambda *_: [])
    monkeypatch.setattr(f"{MODULE}.learn", lambda *_: Adapted({}, 0.0))
    monkeypatch.setattr(f"{MODULE}.SelfCheck.__call__", lambda *_: FAILED)


@pytest.mark.parametrize("heard", [WRONG, ()], ids=["a wrong word", "a failed check"])
def test_learning_anew_that_fails_its_check_leaves_an_active_profile_byte_for_byte(
    profile, voice, config, base, monkeypatch, fails, heard
):
    monkeypatch.setattr(f"{MODULE}.wrong_words", lambda *_: heard)
    before = every_file(profile.folder)
    opened = open_profile("ada", profile.folder.parent)
    assert build(opened, voice, config, base) == WRONG
    assert every_file(profile.folder) == before
    assert opened.manifest.state == ACTIVE


@pytest.mark.parametrize(
    "change",
    [
        lambda copy: copy.judge(RECORDING),
        lambda copy: copy.judge(REFUSED, ("talk",)),
        lambda copy: copy.rebase("cd" * 32),
        lambda copy: copy.put("spellings.json", SPELLED_AS_ANOTHER),
    ],
    ids=["unfinished", "refused", "of another base", "against the commands"],
)
def test_a_profile_that_nobody_can_use_is_refused_with_what_was_learned(
    profile, voice, config, base, tmp_path, fails, change
):
    shutil.copytree(profile.folder, tmp_path / "ada")
    copy = open_profile("ada", tmp_path)
    change(copy)
    assert build(copy, voice, config, base) == WRONG
    again = open_profile("ada", tmp_path)
    assert (again.manifest.state, again.manifest.why) == (REFUSED, WRONG)
    assert again.manifest.base_sha256 == base.model_hash
    assert json.loads(again.read("report.json"))["problems"] == list(WRONG)


def test_a_profile_of_wrong_words_is_refused_and_names_them(profile, voice, config, base):
    swapped = create_profile("eve", base.model_hash, Path(voice.profile.folder))
    other = {"pull more": "pull less", "pull less": "pull more"}
    for take in profile.manifest.takes:
        phrase = other.get(take.phrase, take.phrase)
        renamed = dataclasses.replace(take, phrase=phrase)
        swapped.add_take(profile.sound(take), renamed)
    problems = build(swapped, voice, config, base)
    assert len(problems) == 6
    assert all("wrong word: 'pull " in problem for problem in problems)
    assert swapped.manifest.state == REFUSED
    assert swapped.manifest.why == problems
    assert not swapped.has("model.pt")
    hers = dataclasses.replace(voice, profile=dataclasses.replace(voice.profile, name="eve"))
    with pytest.raises(VoiceProfileError, match="failed its own check"):
        personalise(hers, base)


def test_takes_of_no_command_any_more_are_left_out_with_a_note_and_too_few_refused_by_name(
    voice, config, base
):
    made = create_profile("fay", base.model_hash, Path(voice.profile.folder))
    made.add_take(np.zeros(RATE, np.float32), good_take("camera closer"))
    notes = []
    with pytest.raises(
        VoiceProfileError, match=r"too few takes of 'hey robot' 0, .*at least 3 of each"
    ):
        build(made, voice, config, base, on_note=notes.append)
    allowed = ", ".join(PHRASES)
    assert notes == [f"takes of 'camera closer' are left out: it is no command; allowed: {allowed}"]


def test_takes_that_are_left_out_refuse_nothing(config):
    said = [LabelledTake("f", p, np.zeros(10)) for p in (*PHRASES, "camera closer")]
    talk = LabelledTake("t", "", np.zeros(RATE * 60))
    kept = of_commands(EnrolmentMaterial((*said, *said, *said), (talk,)), PHRASES, lambda _: None)
    require_takes(kept, PHRASES, config)
    assert {one.phrase for one in kept.takes} == set(PHRASES)
