# SPDX-License-Identifier: BSD-3-Clause

import pytest
import yaml

from typed_config import ConfigError
from voice_assist.config import CONFIG_DIR, SECTIONS, load_voice_config, voice_config


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


def test_single_settings_can_be_replaced_and_are_checked():
    assert load_voice_config(audio__vad__start=0.7).audio.vad.start == 0.7
    with pytest.raises(ConfigError, match="detector"):
        load_voice_config(audio__vad__detector="magic")


def test_the_settings_can_come_from_a_mapping_as_ros_gives_it():
    data = {name: yaml.safe_load((CONFIG_DIR / f"{name}.yaml").read_text()) for name in SECTIONS}
    assert voice_config(data) == load_voice_config()


def test_an_unknown_command_names_those_that_exist():
    with pytest.raises(KeyError, match="hey robot, tense"):
        load_voice_config().commands.get("dance")
