# SPDX-License-Identifier: BSD-3-Clause
"""Deleting a profile leaves nothing of it, and never removes what is none."""

import shutil
from unittest.mock import Mock

import pytest

from voice_assist.profile.deletion import delete_profile
from voice_assist.profile.profile import VoiceProfileError, names

BASE = "ab" * 32


def test_deleting_leaves_nothing_even_of_a_damaged_profile(profile):
    (profile.folder / "profile.json").write_bytes(b"\x00")
    assert delete_profile("ada", profile.folder.parent) == 4
    assert not profile.folder.exists()
    assert names(profile.folder.parent) == []
    with pytest.raises(VoiceProfileError, match="no profile 'ada'"):
        delete_profile("ada", profile.folder.parent)


def test_a_folder_that_holds_no_profile_stays(tmp_path):
    letter = tmp_path / "documents" / "letter.txt"
    letter.parent.mkdir()
    letter.touch()
    with pytest.raises(VoiceProfileError, match=r"documents holds 'letter.txt' and no profile"):
        delete_profile("documents", tmp_path)
    assert letter.exists()


@pytest.mark.parametrize("left", ["", ".profile.json.tmp", "takes/0001.wav", "profile.json"])
def test_what_is_left_of_an_unfinished_profile_is_deleted(tmp_path, left):
    (tmp_path / "ada" / "takes" if left.startswith("takes") else tmp_path / "ada").mkdir(
        parents=True
    )
    if left:
        (tmp_path / "ada" / left).touch()
    assert delete_profile("ada", tmp_path) == bool(left)
    assert not list(tmp_path.iterdir())


def test_a_profile_that_was_deleted_in_part_can_be_deleted(profile, monkeypatch):
    with monkeypatch.context() as patched:
        patched.setattr(shutil, "rmtree", Mock(side_effect=KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            delete_profile("ada", profile.folder.parent)
    assert not (profile.folder / "model.pt").exists()
    delete_profile("ada", profile.folder.parent)
    assert not profile.folder.exists()
