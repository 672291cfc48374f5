# SPDX-License-Identifier: BSD-3-Clause
import shutil

import pytest
import yaml

from typed_config import ConfigError
from voice_assist.config import CONFIG_DIR, SECTIONS, load_voice_config, voice_config
from voice_assist.errors import CommandsError


def changed(**changes):
    config = load_voice_config()
    entries = [{**vars(c), "spellings": list(c.spellings)} for c in config.commands.commands]
    next(e for e in entries if e["phrase"] == "tense").update(changes)
    return load_voice_config(commands__commands=entries)


def test_the_shipped_settings_load():
    config = load_voice_config()
    assert config.commands.phrases == (
        *("hey robot", "tense", "release", "pull more", "pull less", "stop", "terminate"),
    )
    assert config.audio.source == "microphone"


def test_every_key_of_the_shipped_files_has_a_comment_in_them():
    for name in SECTIONS:
        lines = (CONFIG_DIR / f"{name}.yaml").read_text().splitlines()
        text = "\n".join(line for line in lines if "#" in line)
        for key in _keys(yaml.safe_load("\n".join(lines))):
            assert key in text, f"{name}.yaml: {key} has no comment"


def _keys(data):
    if isinstance(data, dict):
        for key, value in data.items():
            if not isinstance(value, (dict, list)):
                yield key
            yield from _keys(value)
    elif isinstance(data, list):
        for entry in data:
            yield from _keys(entry)


def test_an_unknown_key_names_the_closest_one(tmp_path):
    shutil.copytree(CONFIG_DIR, tmp_path, dirs_exist_ok=True)
    path = tmp_path / "audio.yaml"
    path.write_text(path.read_text().replace("hangover:", "hangovr:"))
    with pytest.raises(ConfigError, match="did you mean hangover"):
        load_voice_config(tmp_path)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ConfigError, match=r"audio\.yaml"):
        load_voice_config(tmp_path)


def test_single_settings_can_be_replaced_and_are_checked():
    assert load_voice_config(audio__vad__start=0.7).audio.vad.start == 0.7
    with pytest.raises(ConfigError, match="detector"):
        load_voice_config(audio__vad__detector="magic")


def test_a_spelling_cannot_belong_to_two_commands():
    with pytest.raises(CommandsError, match="belongs to"):
        changed(spellings=["Pull, more!"])


def test_a_motion_cannot_be_spelled_with_a_denial():
    with pytest.raises(CommandsError, match="denies"):
        changed(spellings=["don't relax"])


def test_a_spelling_needs_a_word():
    with pytest.raises(CommandsError, match="no word"):
        changed(spellings=["?!"])


def test_a_mode_that_does_not_exist_is_refused():
    with pytest.raises(ConfigError, match="standby, active"):
        changed(modes=["awake"])


def test_the_settings_can_come_from_a_mapping_as_ros_gives_it():
    data = {name: yaml.safe_load((CONFIG_DIR / f"{name}.yaml").read_text()) for name in SECTIONS}
    assert voice_config(data) == load_voice_config()


def test_an_unknown_command_names_those_that_exist():
    with pytest.raises(KeyError, match="hey robot, tense"):
        load_voice_config().commands.get("dance")
