# SPDX-License-Identifier: BSD-3-Clause
"""Profiles: who may read them, what damage is noticed, and that deleting leaves nothing."""

from __future__ import annotations

import json
import stat
from pathlib import Path

import numpy as np
import pytest

from tests.unit.voice_assist.support.records import take
from typed_config import ConfigError
from voice_assist.profile.manifest import ACTIVE, RECORDING, REFUSED
from voice_assist.profile.profile import (
    VoiceProfile,
    VoiceProfileError,
    create_profile,
    delete_profile,
    names,
    open_profile,
    profiles_folder,
)

BASE = "ab" * 32


@pytest.fixture
def profile(tmp_path: Path) -> VoiceProfile:
    made = create_profile("ada", BASE, tmp_path / "profiles")
    sound = np.linspace(-0.5, 0.5, 16000).astype(np.float32)
    made.add_take(sound, take("tense"))
    made.add_take(sound[::-1].copy(), take("release"))
    made.put("model.pt", b"weights")
    return made


def test_only_the_owner_may_read_anything_of_it(profile: VoiceProfile) -> None:
    paths = [profile.folder.parent, profile.folder, *profile.folder.rglob("*")]
    modes = {path: stat.S_IMODE(path.stat().st_mode) for path in paths}
    assert all(mode == (0o700 if path.is_dir() else 0o600) for path, mode in modes.items())


def test_takes_come_back_as_they_were_said(profile: VoiceProfile) -> None:
    opened = open_profile("ada", profile.folder.parent)
    opened.check()
    assert [one.phrase for one in opened.manifest.takes] == ["tense", "release"]
    sound = opened.sound(opened.manifest.takes[0])
    np.testing.assert_allclose(sound, np.linspace(-0.5, 0.5, 16000), atol=1e-4)
    assert opened.digest == profile.digest


@pytest.mark.parametrize("name", ["profile.json", "takes/0002.wav", "model.pt"])
def test_a_file_that_others_may_read_is_refused_with_what_to_do(
    profile: VoiceProfile, name: str
) -> None:
    (profile.folder / name).chmod(0o644)
    with pytest.raises(VoiceProfileError, match=r"permissions 0644, allowed: 0600 \(chmod 600\)"):
        open_profile("ada", profile.folder.parent).check()


def test_a_folder_that_others_may_enter_is_refused(profile: VoiceProfile) -> None:
    profile.folder.chmod(0o755)
    with pytest.raises(VoiceProfileError, match="0755, allowed: 0700"):
        open_profile("ada", profile.folder.parent)


@pytest.mark.parametrize("name", ["takes/0001.wav", "model.pt"])
def test_a_changed_file_is_named(profile: VoiceProfile, name: str) -> None:
    path = profile.folder / name
    data = bytearray(path.read_bytes())
    data[-1] ^= 1
    path.write_bytes(bytes(data))
    with pytest.raises(VoiceProfileError, match=f"{name} has the SHA-256 .* changed or damaged"):
        open_profile("ada", profile.folder.parent).check()


@pytest.mark.parametrize("name", ["takes/0001.wav", "model.pt"])
def test_a_missing_file_is_named(profile: VoiceProfile, name: str) -> None:
    (profile.folder / name).unlink()
    with pytest.raises(VoiceProfileError, match=f"{name} is missing"):
        open_profile("ada", profile.folder.parent).check()


def test_a_link_in_place_of_a_take_is_refused(profile: VoiceProfile, tmp_path: Path) -> None:
    path = profile.folder / "takes/0001.wav"
    elsewhere = tmp_path / "elsewhere.wav"
    path.rename(elsewhere)
    path.symlink_to(elsewhere)
    with pytest.raises(VoiceProfileError, match="no plain file"):
        open_profile("ada", profile.folder.parent).check()


def test_the_profile_of_somebody_else_is_refused(profile: VoiceProfile) -> None:
    profile.folder.rename(profile.folder.parent / "bob")
    with pytest.raises(VoiceProfileError, match="is that of 'ada'"):
        open_profile("bob", profile.folder.parent)


@pytest.mark.parametrize("name", ["none", "", "..", "a/b", "Ada", "a" * 41, "-a"])
def test_names_that_cannot_be_folders_are_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(ConfigError, match="profile name"):
        create_profile(name, BASE, tmp_path)
    assert not list(tmp_path.iterdir())


def test_a_profile_is_not_made_twice(profile: VoiceProfile) -> None:
    with pytest.raises(VoiceProfileError, match="'ada' exists already"):
        create_profile("ada", BASE, profile.folder.parent)


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_a_profile_that_cannot_be_saved_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException
) -> None:
    def fail(_: int) -> None:
        raise error

    with monkeypatch.context() as patched:
        patched.setattr("voice_assist.profile.profile.os.fsync", fail)
        with pytest.raises((VoiceProfileError, KeyboardInterrupt)):
            create_profile("ada", BASE, tmp_path)
    assert not list(tmp_path.iterdir())
    create_profile("ada", BASE, tmp_path)


def test_a_folder_that_holds_no_profile_is_used(tmp_path: Path) -> None:
    (tmp_path / "ada").mkdir(mode=0o755)
    (tmp_path / "ada" / ".profile.json.tmp").touch()
    create_profile("ada", BASE, tmp_path)
    assert open_profile("ada", tmp_path).manifest.takes == ()
    (tmp_path / "bob" / "takes").mkdir(parents=True)
    with pytest.raises(VoiceProfileError, match="'bob' exists already"):
        create_profile("bob", BASE, tmp_path)


def test_a_file_that_the_manifest_does_not_name_is_not_read(profile: VoiceProfile) -> None:
    (profile.folder / "other.bin").write_bytes(b"?")
    with pytest.raises(VoiceProfileError, match=r"has no file 'other.bin', only: model.pt"):
        profile.read("other.bin")


def test_a_refusal_keeps_its_reasons(profile: VoiceProfile) -> None:
    profile.judge(REFUSED, ("takes: 3 of 21 right",))
    manifest = open_profile("ada", profile.folder.parent).manifest
    assert manifest.state == REFUSED
    assert manifest.why == ("takes: 3 of 21 right",)
    with pytest.raises(ConfigError, match="why"):
        profile.judge(ACTIVE, ("but why?",))


def test_what_was_dropped_is_gone(profile: VoiceProfile) -> None:
    profile.drop("model.pt")
    assert not profile.has("model.pt")
    assert not (profile.folder / "model.pt").exists()
    open_profile("ada", profile.folder.parent).check()


def test_deleting_leaves_nothing_even_of_a_damaged_profile(profile: VoiceProfile) -> None:
    (profile.folder / "profile.json").write_bytes(b"\x00")
    assert delete_profile("ada", profile.folder.parent) == 4
    assert not profile.folder.exists()
    assert names(profile.folder.parent) == []
    with pytest.raises(VoiceProfileError, match="no profile 'ada'"):
        delete_profile("ada", profile.folder.parent)


def test_the_folder_is_the_users_own_unless_another_is_given(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv("VOICE_ASSIST_PROFILES", raising=False)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    assert profiles_folder() == tmp_path / "voice_assist" / "profiles"
    monkeypatch.setenv("VOICE_ASSIST_PROFILES", str(tmp_path / "mine"))
    assert profiles_folder() == tmp_path / "mine"
    assert profiles_folder(tmp_path / "given") == tmp_path / "given"
    with pytest.raises(VoiceProfileError, match=r"profiles in '~nobody-there/x': .*; allowed in"):
        profiles_folder("~nobody-there/x")


def test_a_broken_off_write_leaves_the_profile_as_it_was(
    profile: VoiceProfile, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = profile.digest

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(VoiceProfileError, match="No space left"):
        profile.add_take(np.zeros(1600, np.float32), take())
    monkeypatch.undo()
    opened = open_profile("ada", profile.folder.parent)
    opened.check()
    assert opened.digest == before


def test_a_manifest_with_an_unknown_key_is_damaged(profile: VoiceProfile) -> None:
    path = profile.folder / "profile.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), "extra": 1}))
    with pytest.raises(VoiceProfileError, match=r"profile.json is damaged: profile.json.extra"):
        open_profile("ada", profile.folder.parent)


def test_recording_is_the_first_state(profile: VoiceProfile) -> None:
    assert profile.manifest.state == RECORDING
