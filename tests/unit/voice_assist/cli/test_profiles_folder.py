# SPDX-License-Identifier: BSD-3-Clause
"""`enroll` and `profiles` look where the nodes look: option, profile.yaml, environment."""

import shutil

import pytest

from voice_assist.cli import enroll as enroll_module
from voice_assist.cli.main import main
from voice_assist.config import CONFIG_DIR
from voice_assist.profile.profile import ENV, create_profile, open_profile


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
    for place in ("set", "given", "environment"):
        create_profile(place, "ab" * 32, tmp_path / place)
    monkeypatch.setenv(ENV, str(tmp_path / "environment"))
    return tmp_path


def arguments(profiles, config, place):
    before = ["--config", str(config)] if place != "environment" else []
    return before, ["--profiles", str(profiles / "given")] if place == "given" else []


@pytest.mark.parametrize("place", ["set", "given", "environment"])
def test_profiles_are_those_of_the_option_or_the_settings(profiles, config, place, capsys):
    before, after = arguments(profiles, config, place)
    with pytest.raises(SystemExit) as ended:
        main([*before, "profiles", "list", *after])
    shown = capsys.readouterr().out
    assert not ended.value.code
    assert [name for name in ("set", "given", "environment") if f"\n{name} " in shown] == [place]


def test_the_profile_of_the_settings_is_deleted_and_no_other(profiles, config):
    create_profile("ada", "ab" * 32, profiles / "set")
    create_profile("ada", "ab" * 32, profiles / "environment")
    with pytest.raises(SystemExit):
        main(["--config", str(config), "profiles", "delete", "ada", "--yes"])
    assert not (profiles / "set" / "ada").exists()
    open_profile("ada", profiles / "environment")


@pytest.mark.parametrize("place", ["set", "given", "environment"])
def test_a_voice_is_learned_where_the_nodes_look(profiles, config, place, monkeypatch):
    asked = []
    monkeypatch.setattr(enroll_module, "enroll", lambda voice, request: asked.append(request))
    before, after = arguments(profiles, config, place)
    with pytest.raises(SystemExit):
        main([*before, "enroll", "bob", *after])
    assert enroll_module.profiles_folder(asked[0].folder) == profiles / place
