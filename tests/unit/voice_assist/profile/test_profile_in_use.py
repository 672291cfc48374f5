# SPDX-License-Identifier: BSD-3-Clause
"""A profile at work: which one is used, which is refused and why, and what deletes it."""

import json

import numpy as np
import pytest
import rospy
import torch

from rst_control.host.respawn import RESTART
from tests.unit.voice_assist.support.records import take
from voice_assist import recognizer
from voice_assist.assembly import make_recognizer
from voice_assist.cli import enroll
from voice_assist.config import load_voice_config
from voice_assist.config.commands import ENGLISH, LANGUAGES
from voice_assist.config.profile import NOBODY
from voice_assist.profile import model_file, thresholds
from voice_assist.profile.active import (
    PersonalRecognizer,
    personalise,
    profile_in_use,
    with_profile,
)
from voice_assist.profile.manifest import ACTIVE, RECORDING, REFUSED, to_bytes
from voice_assist.profile.profile import VoiceProfileError, create_profile, facts_of
from voice_assist.replay.replayer import restore_settings
from voice_assist.ros.node_settings import NOTED, keep_profile, node_settings
from voice_assist.types import RATE


@pytest.fixture
def profile(tmp_path, base):
    made = create_profile("ada", base.model_hash, tmp_path / "profiles")
    state = {"ctc.bias": base.model.get_parameter("ctc.bias").detach() + 1.0}
    made.put(model_file.NAME, model_file.to_bytes(state, base.model_hash))
    wanted = (thresholds.Setting(phrase="pull more", least_confidence=0.8),)
    made.put(thresholds.NAME, to_bytes(thresholds.Settings(commands=wanted)))
    made.judge(ACTIVE)
    return made


def config(profile, language=ENGLISH, **changes):
    wanted = {"name": "ada", "folder": str(profile.folder.parent), **changes}
    settings = {f"profile__{key}": value for key, value in wanted.items()}
    return load_voice_config(language=language, **settings)


def test_nobody_is_the_base_itself(base):
    settings = load_voice_config()
    assert settings.profile.name == NOBODY
    assert personalise(settings, base) is base
    assert with_profile(settings) == (settings, None)
    assert facts_of(base) == {}


def test_an_active_profile_brings_its_weights_thresholds_and_digest(profile, base):
    settings = config(profile)
    personal = personalise(settings, base)
    assert isinstance(personal, PersonalRecognizer)
    change = personal.model.get_parameter("ctc.bias") - base.model.get_parameter("ctc.bias")
    torch.testing.assert_close(change, torch.ones_like(change), atol=0.01, rtol=0.0)
    active, voiceprint = with_profile(settings)
    assert active.commands.get("pull more").min_confidence == 0.9
    assert voiceprint is None
    assert facts_of(personal) == {"profile": "ada", "profile_sha256": profile.digest}
    assert personalise(config(profile, name=NOBODY), base) is base  # by one switch
    profile.put("voiceprint.npz", b"print")
    assert with_profile(settings)[1] == b"print"


def damage(profile):
    path = profile.folder / model_file.NAME
    path.write_bytes(path.read_bytes()[:-100])


TALKED = "commands taken from talk: 2, allowed: up to 0"


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("ada", lambda p: p.judge(REFUSED, (TALKED,)), rf"failed its own check \({TALKED}"),
        ("ada", lambda p: p.judge(RECORDING), r"is not finished.*voice_assist enroll ada"),
        ("ada", lambda p: p.rebase("cd" * 32), "on top of the recogniser cdcdcdcdcdcd, allowed: "),
        ("ada", damage, "model.pt has the SHA-256"),
        ("bob", lambda p: None, r"no profile 'bob' in .*, there: ada"),
    ],
)
def test_a_profile_that_cannot_be_used_is_refused_and_says_why(profile, base, name, change, words):
    change(profile)
    with pytest.raises(VoiceProfileError, match=words):
        personalise(config(profile, name=name), base)


@pytest.mark.parametrize("language", [x for x in LANGUAGES if x != ENGLISH])
def test_a_profile_of_another_language_is_not_used(profile, base, language, monkeypatch):
    monkeypatch.setattr(recognizer, "load_recognizer", lambda *_: base)
    profile.add_take(np.zeros(RATE, np.float32), take("stop"))
    foreign = config(profile, language)
    first = foreign.commands.fixed_phrases[0]
    found = f"profile 'ada' was not learned from takes of {first!r}, allowed with language"
    command = f"{language}: .*voice_assist --language {language} enroll ada"
    for use in (make_recognizer, with_profile):
        with pytest.raises(VoiceProfileError, match=f"^{found} {command}"):
            use(foreign)


def test_a_profile_learned_from_every_phrase_of_the_language_is_used(profile, base):
    german = config(profile, "de")
    *phrases, last = german.commands.fixed_phrases
    learned = [thresholds.Setting(phrase=p, least_confidence=0.8) for p in (*phrases, last)]
    profile.put(thresholds.NAME, to_bytes(thresholds.Settings(commands=tuple(learned))))
    for phrase in phrases:
        profile.add_take(np.zeros(RATE, np.float32), take(phrase))
    with pytest.raises(VoiceProfileError, match=f"not learned from takes of {last!r}"):
        personalise(german, base)
    profile.add_take(np.zeros(RATE, np.float32), take(last))
    assert isinstance(personalise(german, base), PersonalRecognizer)
    in_english = thresholds.Settings(commands=tuple(learned[:-1]))
    profile.put(thresholds.NAME, to_bytes(in_english))  # learned anew, from other takes
    with pytest.raises(VoiceProfileError, match=f"not learned from takes of {last!r}"):
        personalise(german, base)


def test_a_pinned_profile_that_changed_is_not_used(profile):
    pinned = config(profile, sha256=profile.digest).profile
    assert profile_in_use(pinned).digest == profile.digest
    profile.put("report.md", b"changed")
    assert profile_in_use(config(profile, sha256=profile.digest).profile)
    with pytest.raises(VoiceProfileError, match="it was changed since"):
        profile_in_use(pinned)


def test_a_take_that_comes_while_a_pinned_profile_is_in_use_changes_nothing(profile):
    pinned = config(profile, sha256=profile.digest).profile
    whole = config(profile, sha256=profile.manifest_digest).profile
    assert profile_in_use(whole).name == "ada"  # as an older recording has pinned it
    profile.add_take(np.zeros(RATE, np.float32), take("tense"))
    assert len(profile_in_use(pinned).manifest.takes) == 1
    with pytest.raises(VoiceProfileError, match="it was changed since"):
        profile_in_use(whole)


@pytest.mark.parametrize("name", [model_file.NAME, thresholds.NAME, "voiceprint.npz"])
def test_a_pinned_profile_whose_hearing_changed_is_not_used(profile, base, name):
    pinned = config(profile, sha256=profile.digest).profile
    before = profile.manifest
    profile.put(name, b"other")
    with pytest.raises(VoiceProfileError, match="it was changed since"):
        profile_in_use(pinned)
    profile.drop(name)
    if name in {file.name for file in before.files}:
        with pytest.raises(VoiceProfileError, match="it was changed since"):
            profile_in_use(pinned)
    else:
        assert profile_in_use(pinned)
    profile.rebase("cd" * 32)
    with pytest.raises(VoiceProfileError, match="it was changed since"):
        profile_in_use(pinned)


def test_settings_recorded_before_there_were_profiles_mean_nobody():
    recorded = {"recognizer": {"model": "embedded"}}
    settings, warnings = restore_settings(recorded, None)
    assert settings.profile.name == NOBODY
    assert not any("profile" in warning or "speaker" in warning for warning in warnings)
    assert settings.speaker.gate == "off"


def test_deleting_asks_first(profile, capsys):
    asked, root = [], profile.folder.parent
    assert enroll.delete("ada", root, sure=False, ask=lambda words: asked.append(words) or "") == 1
    assert profile.folder.exists()
    assert "all its recordings" in asked[0]
    assert enroll.delete("ada", root, sure=False, ask=lambda _: "y") == 0
    assert not profile.folder.exists()
    assert "3 files deleted" in capsys.readouterr().out


def test_profiles_are_listed_and_shown_with_what_is_wrong(profile, capsys):
    root = profile.folder.parent
    create_profile("bob", "ab" * 32, root)
    (root / "bob" / "profile.json").write_text("{")
    assert enroll.manage("list", None, root, False) == 0
    listed = capsys.readouterr().out
    assert "active, 0 takes" in listed
    assert "profile.json is damaged" in listed.replace("\n", " ")
    assert enroll.manage("show", "ada", root, False) == 0
    assert profile.digest[:20] in capsys.readouterr().out.replace("\n", "")
    with pytest.raises(VoiceProfileError, match="needs the name of a profile, there: ada, bob"):
        enroll.manage("show", None, root, False)


class Launched:
    """A voice node's parameters; `start` is what each of its starts does with the profile."""

    def __init__(self, monkeypatch, profile, sha256=""):
        folder = str(profile.folder.parent)
        self.tree = {"profile": {"name": "ada", "folder": folder, "sha256": sha256}}
        self.beside = {}
        self.errors, self.is_started, self.setenv = [], False, monkeypatch.setenv
        monkeypatch.delenv(RESTART, raising=False)
        monkeypatch.setattr(rospy, "get_param", self.get)
        monkeypatch.setattr(rospy, "set_param", self.set)
        note = lambda words, *parts: self.errors.append(words % parts)  # noqa: E731
        monkeypatch.setattr(rospy, "logerr", note)

    def get(self, name, default=None):
        tree = json.loads(json.dumps(self.tree if name.startswith("~") else self.beside))
        return tree if name == "~" else tree.get(name.removeprefix("~"), default)

    def set(self, name, value):
        (self.tree if name.startswith("~") else self.beside)[name.removeprefix("~")] = value

    def start(self):
        if self.is_started:
            self.setenv(RESTART, "1")
        self.is_started = True
        config = node_settings().profile
        digest = profile_in_use(config).digest
        keep_profile(config, digest)
        assert self.tree["profile"]["sha256"] == digest  # for a replay
        return digest


def learn(profile):
    profile.put("voiceprint.npz", b"another")
    profile.judge(ACTIVE)


def test_after_a_crash_a_profile_that_was_learned_anew_is_used_and_said_once(profile, monkeypatch):
    launched = Launched(monkeypatch, profile)
    before = [launched.start() for _ in range(2)]
    assert set(before) == {profile.digest} and launched.errors == []
    learn(profile)
    after = launched.start()
    assert after not in before
    (error,) = launched.errors
    assert "'ada'" in error and after[:12] in error and before[0][:12] in error
    assert set(launched.tree) == {"profile", "launched"}  # a replay knows them
    assert launched.start() == after and len(launched.errors) == 1


def test_after_a_crash_a_profile_is_still_the_one_that_the_launch_asked_for(profile, monkeypatch):
    launched = Launched(monkeypatch, profile, sha256=profile.digest)
    launched.beside[NOTED] = profile.digest  # of a launch before
    for _ in range(2):
        launched.start()
    learn(profile)
    with pytest.raises(VoiceProfileError, match="it was changed since"):
        launched.start()
    assert launched.errors == []
