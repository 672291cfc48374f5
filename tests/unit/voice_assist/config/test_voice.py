# SPDX-License-Identifier: BSD-3-Clause

import pytest
import yaml

from typed_config import ConfigError, load_config, load_yaml
from voice_assist.config import (
    CONFIG_DIR,
    SECTIONS,
    CommandsConfig,
    load_voice_config,
    voice_config,
)


def test_the_shipped_settings_load_and_an_unknown_command_names_those_there_are():
    config = load_voice_config()
    phrases = ("hey robot", "tense", "release", "pull more", "pull less", "stop", "terminate")
    assert config.commands.phrases == phrases
    assert config.audio.source == "microphone"
    with pytest.raises(KeyError, match="hey robot, tense"):
        config.commands.get("dance")


@pytest.mark.parametrize("file", ["theatre_commands.yaml", "endoscope_commands.yaml"])
def test_an_english_example_takes_the_phrases_of_the_shipped_commands_as_these_do(file):
    shipped = load_voice_config().commands
    example = load_config(CommandsConfig, load_yaml(CONFIG_DIR / file), file)
    shared = set(example.phrases) & set(shipped.phrases)
    assert {"hey robot", "stop", "terminate"} <= shared
    assert [example.get(phrase) for phrase in shared] == [shipped.get(p) for p in shared]
    others = [c for c in example.commands if c.is_motion and c.phrase not in shared]
    assert all(command.min_confidence == 0.9 for command in others)


def test_every_key_of_the_shipped_files_has_a_comment_in_them():
    for name in SECTIONS:
        lines = (CONFIG_DIR / f"{name}.yaml").read_text().splitlines()
        text = "\n".join(line for line in lines if "#" in line)
        for key in _keys(yaml.safe_load("\n".join(lines))):
            assert key in text, f"{name}.yaml: {key} has no comment"


def _keys(data):
    for key, value in data.items() if isinstance(data, dict) else enumerate(data):
        if isinstance(value, (dict, list)):
            yield from _keys(value)
        elif isinstance(data, dict):
            yield key


def test_single_settings_can_be_replaced_and_are_checked():
    assert load_voice_config(audio__vad__start=0.7).audio.vad.start == 0.7
    with pytest.raises(ConfigError, match="detector"):
        load_voice_config(audio__vad__detector="magic")


@pytest.mark.parametrize(("pre_roll", "least"), [(0.44, 1.0), (1.0, 1.56), (1.9, 2.46)])
def test_a_command_fits_into_an_utterance_behind_what_is_kept_before_it(pre_roll, least):
    kept = {"audio__vad__pre_roll": pre_roll}
    assert load_voice_config(audio__vad__max_utterance=least, **kept)
    words = rf"vad\.max_utterance.*from {least + 0.01:g} s on: pre_roll, min_speech and 0\.5 s"
    with pytest.raises(ConfigError, match=words):
        load_voice_config(audio__vad__max_utterance=least, audio__vad__pre_roll=pre_roll + 0.01)


def test_of_an_utterance_no_more_is_taken_for_its_whole_than_a_recogniser_hears():
    silence = {"recognizer__early__silence_added": 0.5}
    early = load_voice_config(recognizer__early__window=9.5, **silence).recognizer.early
    assert early.window == 9.5
    for window in (9.6, 20.0):
        words = rf"early\.window.*{window:g}.*allowed: up to 9.5 s: a recogniser hears 10 s"
        with pytest.raises(ConfigError, match=words):
            load_voice_config(recognizer__early__window=window, **silence)


def test_the_settings_can_come_from_a_mapping_as_ros_gives_it():
    data = {name: yaml.safe_load((CONFIG_DIR / f"{name}.yaml").read_text()) for name in SECTIONS}
    assert voice_config(data) == load_voice_config()
