# SPDX-License-Identifier: BSD-3-Clause
"""A take for which no sound comes fails in words; its caller does not wait for ever."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from voice_assist.config import load_voice_config
from voice_assist.errors import AudioError
from voice_assist.ros import topic_source
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
    node._believed = SimpleNamespace(hear=lambda *_: topic)
    with pytest.raises(AudioError, match="no sound on /voice_assist/audio"):
        next(node._listen())
    assert left == [True]
