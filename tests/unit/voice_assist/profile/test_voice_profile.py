# SPDX-License-Identifier: BSD-3-Clause
"""Profiles: who may read them, what damage is noticed, and that deleting leaves nothing."""

import json
import math
import stat
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest

from tests.unit.voice_assist.support.records import take
from typed_config import ConfigError
from voice_assist.profile.manifest import ACTIVE, RECORDING, REFUSED
from voice_assist.profile.profile import (
    VoiceProfileError,
    create_profile,
    names,
    open_profile,
    profiles_folder,
)

BASE = "ab" * 32


def test_only_the_owner_may_read_anything_of_it(profile):
    paths = [profile.folder.parent, profile.folder, *profile.folder.rglob("*")]
    modes = {path: stat.S_IMODE(path.stat().st_mode) for path in paths}
    assert all(mode == (0o700 if path.is_dir() else 0o600) for path, mode in modes.items())


def test_takes_come_back_as_they_were_said(profile):
    opened = open_profile("ada", profile.folder.parent)
    opened.check()
    assert [one.phrase for one in opened.manifest.takes] == ["tense", "release"]
    assert opened.manifest.state == RECORDING
    sound = opened.sound(opened.manifest.takes[0])
    np.testing.assert_allclose(sound, np.linspace(-0.5, 0.5, 16000), atol=1e-4)
    assert opened.manifest_digest == profile.manifest_digest


def changed(path):
    *data, last = path.read_bytes()
    path.write_bytes(bytes([*data, last ^ 1]))


def linked(path):
    path.rename(path.parents[2] / "elsewhere")
    path.symlink_to(path.parents[2] / "elsewhere")


@pytest.mark.parametrize("name", ["takes/0001.wav", "model.pt"])
@pytest.mark.parametrize(
    ("harm", "words"),
    [
        (changed, "has the SHA-256 .* changed or damaged"),
        (Path.unlink, "is missing"),
        (linked, "is missing, or no plain file"),
        (lambda path: path.chmod(0o644), r".*permissions 0644, allowed: 0600 \(chmod 600\)"),
    ],
)
def test_a_file_that_was_meddled_with_is_named_with_what_to_do(profile, harm, words, name):
    harm(profile.folder / name)
    with pytest.raises(VoiceProfileError, match=f"{name} {words}"):
        open_profile("ada", profile.folder.parent).check()


@pytest.mark.parametrize(
    ("name", "mode", "words"),
    [("", 0o755, "0755, allowed: 0700"), ("profile.json", 0o644, "0644, allowed: 0600")],
)
def test_what_others_may_enter_or_read_is_refused(profile, name, mode, words):
    (profile.folder / name).chmod(mode)
    with pytest.raises(VoiceProfileError, match=words):
        open_profile("ada", profile.folder.parent)


def test_the_profile_of_somebody_else_is_refused_and_none_is_made_twice(profile):
    with pytest.raises(VoiceProfileError, match="'ada' exists already"):
        create_profile("ada", BASE, profile.folder.parent)
    profile.folder.rename(profile.folder.parent / "bob")
    with pytest.raises(VoiceProfileError, match="is that of 'ada'"):
        open_profile("bob", profile.folder.parent)


@pytest.mark.parametrize("name", ["none", "", "..", "a/b", "Ada", "a" * 41, "-a"])
def test_names_that_cannot_be_folders_are_refused(tmp_path, name):
    with pytest.raises(ConfigError, match="profile name"):
        create_profile(name, BASE, tmp_path)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_a_profile_that_cannot_be_saved_leaves_nothing(tmp_path, monkeypatch, error):
    with monkeypatch.context() as patched:
        patched.setattr("voice_assist.profile.profile.os.fsync", Mock(side_effect=error))
        with pytest.raises((VoiceProfileError, KeyboardInterrupt)):
            create_profile("ada", BASE, tmp_path)
    assert not list(tmp_path.iterdir())
    create_profile("ada", BASE, tmp_path)


def test_a_folder_that_holds_no_profile_is_used(tmp_path):
    (tmp_path / "ada").mkdir(mode=0o755)
    (tmp_path / "ada" / ".profile.json.tmp").touch()
    create_profile("ada", BASE, tmp_path)
    assert open_profile("ada", tmp_path).manifest.takes == ()
    (tmp_path / "bob" / "takes").mkdir(parents=True)
    with pytest.raises(VoiceProfileError, match="'bob' exists already"):
        create_profile("bob", BASE, tmp_path)


def test_a_file_that_the_manifest_does_not_name_is_not_read_and_one_that_was_dropped_is_gone(
    profile,
):
    (profile.folder / "other.bin").write_bytes(b"?")
    with pytest.raises(VoiceProfileError, match=r"has no file 'other.bin', only: model.pt"):
        profile.read("other.bin")
    profile.drop("model.pt")
    assert not profile.has("model.pt")
    assert not (profile.folder / "model.pt").exists()
    open_profile("ada", profile.folder.parent).check()


def test_a_refusal_keeps_its_reasons(profile):
    profile.judge(REFUSED, ("takes: 3 of 21 right",))
    manifest = open_profile("ada", profile.folder.parent).manifest
    assert manifest.state == REFUSED
    assert manifest.why == ("takes: 3 of 21 right",)
    with pytest.raises(ConfigError, match="why"):
        profile.judge(ACTIVE, ("but why?",))


def test_a_folder_of_other_files_is_not_taken_over(tmp_path):
    folder = tmp_path / "documents"
    folder.mkdir(mode=0o755)
    (folder / "letter.txt").touch()
    words = r"documents holds 'letter.txt' and no profile, allowed: .* or an empty one"
    with pytest.raises(VoiceProfileError, match=words):
        create_profile("documents", BASE, tmp_path)
    assert [path.name for path in folder.iterdir()] == ["letter.txt"]
    assert stat.S_IMODE(folder.stat().st_mode) == 0o755


def test_a_folder_whose_name_no_profile_can_have_is_none(profile):
    root = profile.folder.parent
    for name in ("ada.old", "none", "Ada"):
        (root / name).mkdir()
        (root / name / "profile.json").touch()
    assert names(root) == ["ada"]


def test_what_could_not_be_read_again_is_not_written(profile):
    before = sorted(profile.folder.rglob("*"))
    odd = replace(take(), source="stop\u200e.wav")
    with pytest.raises(VoiceProfileError, match=r"'ada'.*takes\[2\].source is .*printable text"):
        profile.add_take(np.zeros(1600, np.float32), odd)
    with pytest.raises(VoiceProfileError, match=r"why\[0\] is .*printable text"):
        profile.judge(REFUSED, ("takes: \x07",))
    with pytest.raises(VoiceProfileError, match="nan"):
        profile.add_take(np.zeros(1600, np.float32), replace(take(), snr_db=math.nan))
    assert sorted(profile.folder.rglob("*")) == before
    again = open_profile("ada", profile.folder.parent)
    assert again.manifest_digest == profile.manifest_digest


def test_the_folder_is_the_users_own_unless_another_is_given(monkeypatch, tmp_path):
    monkeypatch.delenv("VOICE_ASSIST_PROFILES", raising=False)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    assert profiles_folder() == tmp_path / "voice_assist" / "profiles"
    monkeypatch.setenv("VOICE_ASSIST_PROFILES", str(tmp_path / "mine"))
    assert profiles_folder() == tmp_path / "mine"
    assert profiles_folder(tmp_path / "given") == tmp_path / "given"
    with pytest.raises(VoiceProfileError, match=r"profiles in '~nobody-there/x': .*; allowed in"):
        profiles_folder("~nobody-there/x")


def test_a_broken_off_write_leaves_the_profile_as_it_was(profile, monkeypatch):
    before = profile.manifest_digest

    full = Mock(side_effect=OSError(28, "No space left on device"))
    with monkeypatch.context() as patched:
        patched.setattr("os.fsync", full)
        with pytest.raises(VoiceProfileError, match="No space left"):
            profile.add_take(np.zeros(1600, np.float32), take())
    opened = open_profile("ada", profile.folder.parent)
    opened.check()
    assert opened.manifest_digest == before


def test_a_manifest_with_an_unknown_key_is_damaged(profile):
    path = profile.folder / "profile.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), "extra": 1}))
    with pytest.raises(VoiceProfileError, match=r"profile.json is damaged: profile.json.extra"):
        open_profile("ada", profile.folder.parent)
