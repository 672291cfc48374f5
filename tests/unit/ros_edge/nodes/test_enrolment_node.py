# SPDX-License-Identifier: BSD-3-Clause
"""A take for which no sound comes fails in words; the settings are those of its folder."""

import shutil
from dataclasses import replace
from types import SimpleNamespace

import pytest

from typed_config import ConfigError
from voice_assist.config import CONFIG_DIR, load_voice_config
from voice_assist.errors import AudioError
from voice_assist.profile.profile import VoiceProfileError
from voice_assist.ros import enrolment_node, topic_source
from voice_assist.ros.enrolment_node import EnrolmentNode


def test_a_take_without_sound_fails(monkeypatch):
    fake = SimpleNamespace(is_shutdown=lambda: False, resolve_name=lambda name: f"/{name}")
    monkeypatch.setattr(topic_source, "rospy", fake)
    voice = load_voice_config()
    audio = replace(voice.audio, topic=replace(voice.audio.topic, lost_after=0.01))
    node = object.__new__(EnrolmentNode)
    node._voice = replace(voice, audio=audio)
    left = []
    topic = SimpleNamespace(unregister=lambda: left.append(True))
    node._sound = SimpleNamespace(subscribe=lambda *_: topic)
    with pytest.raises(AudioError, match="no sound on /voice_assist/audio"):
        next(node._listen())
    assert left == [True]


@pytest.fixture
def settings(tmp_path, monkeypatch):
    """The node's settings with some private parameters; the folder has a take of four seconds."""
    folder = tmp_path / "settings"
    shutil.copytree(CONFIG_DIR, folder)
    file = folder / "enrolment.yaml"
    lines = file.read_text().splitlines()
    changed = ("take: 4.0" if line.startswith("take:") else line for line in lines)
    file.write_text("\n".join(changed) + "\n")

    def settings(**given):
        given = {
            f"~{name}": str(folder) if value == "own" else value for name, value in given.items()
        }
        monkeypatch.setattr(enrolment_node, "rospy", SimpleNamespace(get_param=given.get))
        return enrolment_node._settings()

    return settings


def test_the_settings_are_those_of_the_folder_and_the_language_that_are_given(settings):
    voice, config = settings()
    assert voice == load_voice_config() and config.take != 4.0
    voice, config = settings(config="own", language="de")
    assert voice.commands.language == "de" and config.take == 4.0


def test_a_language_or_phrases_that_no_profile_can_learn_are_refused(settings):
    with pytest.raises(ConfigError, match="'it', allowed: en, de"):
        settings(language="it")
    with pytest.raises(VoiceProfileError, match="letters a to z only"):
        settings(language="ja")
