# SPDX-License-Identifier: BSD-3-Clause
"""`enroll` and `profiles` look where the nodes look: option, profile.yaml, environment."""

import io
import shutil

import pytest

from tests.unit.voice_assist.support.adaptable import Adaptable
from voice_assist.cli import enroll as enroll_module
from voice_assist.cli.main import main
from voice_assist.config import CONFIG_DIR
from voice_assist.profile.profile import ENV, create_profile, open_profile

PLACES = ("set", "given", "environment")


@pytest.fixture
def config(tmp_path):
    """Settings whose profile.yaml names a folder."""
    config = tmp_path / "config"
    shutil.copytree(CONFIG_DIR, config)
    path = config / "profile.yaml"
    text = path.read_text(encoding="utf-8")
    assert 'folder: ""' in text
    path.write_text(text.replace('folder: ""', f"folder: {tmp_path / 'set'}"), encoding="utf-8")
    return config


@pytest.fixture
def profiles(tmp_path, monkeypatch):
    """A profile in each place, called as the place."""
    for place in PLACES:
        create_profile(place, "ab" * 32, tmp_path / place)
    monkeypatch.setenv(ENV, str(tmp_path / "environment"))
    return tmp_path


@pytest.mark.parametrize("place", PLACES)
def test_profiles_are_found_and_learned_where_the_nodes_look(
    profiles, config, place, capsys, monkeypatch
):
    before = ["--config", str(config)] if place != "environment" else []
    after = ["--profiles", str(profiles / "given")] if place == "given" else []
    with pytest.raises(SystemExit) as ended:
        main([*before, "profiles", "list", *after])
    shown = capsys.readouterr().out
    assert not ended.value.code
    assert [name for name in PLACES if f"\n{name} " in shown] == [place]
    asked = []
    monkeypatch.setattr(enroll_module, "enroll", lambda voice, request: asked.append(request))
    with pytest.raises(SystemExit):
        main([*before, "enroll", "bob", *after])
    assert enroll_module.profiles_folder(asked[0].folder) == profiles / place


def test_the_profile_of_the_settings_is_deleted_and_no_other(profiles, config):
    create_profile("ada", "ab" * 32, profiles / "set")
    create_profile("ada", "ab" * 32, profiles / "environment")
    with pytest.raises(SystemExit):
        main(["--config", str(config), "profiles", "delete", "ada", "--yes"])
    assert not (profiles / "set" / "ada").exists()
    open_profile("ada", profiles / "environment")


def refused(capsys, *words):
    """What is printed and what is wrong; the exit status is 2."""
    with pytest.raises(SystemExit) as ended:
        main([str(word) for word in words])
    assert ended.value.code == 2
    return capsys.readouterr()


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("nobody", "no profile 'nobody' in {}, there: set"),
        ("../x", "profile name is '../x'"),
        ("documents", "documents holds 'letter.txt' and no profile, allowed"),
    ],
)
def test_nothing_is_asked_about_a_profile_that_is_not_there(profiles, capsys, name, words):
    letter = profiles / "set" / "documents" / "letter.txt"
    letter.parent.mkdir()
    letter.touch()
    folder = profiles / "set"
    shown = refused(capsys, "profiles", "delete", name, "--profiles", folder)
    assert shown.out == "" and words.format(folder) in shown.err
    assert letter.exists()


def test_a_damaged_profile_or_an_odd_folder_does_not_end_the_list(profiles, capsys):
    folder = profiles / "set"
    (folder / "set").rename(folder / "set.old")
    for name in ("ada", "zoe"):
        create_profile(name, "ab" * 32, folder)
    damaged = folder / "ada" / "profile.json"
    damaged.write_text(damaged.read_text().replace('"recording"', '"[/odd]"'))
    with pytest.raises(SystemExit) as ended:
        main(["profiles", "list", "--profiles", str(folder)])
    assert not ended.value.code
    shown = " ".join(capsys.readouterr().out.split())
    assert shown.startswith("2 profiles in")
    assert shown.index(" ada ") < shown.index("profile.json is damaged")
    assert shown.endswith("zoe recording, 0 takes")


def test_a_question_without_an_answer_deletes_nothing(profiles, capsys, monkeypatch):
    monkeypatch.setattr("sys.stdin", io.StringIO(""))
    folder = profiles / "set"
    shown = refused(capsys, "profiles", "delete", "set", "--profiles", folder)
    words = "no answer; nothing was deleted (--yes deletes without a question)"
    assert shown.err == f"voice_assist profiles: {words}\n"
    open_profile("set", folder)


@pytest.mark.parametrize("verb", [["profiles", "list"], ["enroll", "ada"]])
def test_a_file_is_no_folder_of_profiles(tmp_path, capsys, monkeypatch, verb):
    monkeypatch.setattr("voice_assist.recognizer.load_recognizer", lambda *_, **__: Adaptable())
    (tmp_path / "file").write_text("")
    shown = refused(capsys, *verb, "--profiles", tmp_path / "file")
    assert f"profiles in '{tmp_path / 'file'}': it is no folder; allowed" in shown.err
