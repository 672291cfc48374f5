# SPDX-License-Identifier: BSD-3-Clause
"""The enrolment node subscribes once, however many takes there are, and names strangers."""

from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import pytest
import rospy

from voice_assist.config import load_voice_config
from voice_assist.errors import AudioError
from voice_assist.msg import AudioChunk
from voice_assist.ros import enrolment_node, topic_source
from voice_assist.ros.enrolment_node import EnrolmentNode
from voice_assist.types import RATE

BLOCK = 512  # samples


class Known:
    """Stands for ROS: who is subscribed to."""

    def __init__(self):
        self.callbacks, self.statuses = [], 0

    def hear(self, by, topic, kind, callback):
        assert by == "voice"
        self.callbacks.append((topic, callback))
        return SimpleNamespace(unregister=lambda: None)

    def publish_status(self):
        self.statuses += 1

    def say(self, first_sample):
        """Publish a block of sound."""
        chunk = AudioChunk(rate=RATE, first_sample=first_sample, samples=[0] * BLOCK)
        chunk.header.stamp = rospy.Time.from_sec(100.0 + first_sample / RATE)
        for topic, callback in self.callbacks:
            if topic == "voice_assist/audio":
                callback(chunk)


@pytest.fixture
def known(monkeypatch):
    known = Known()
    monkeypatch.setattr(enrolment_node, "Believed", lambda: known)
    monkeypatch.setattr(enrolment_node, "limit_torch", lambda _: None)
    monkeypatch.setattr(enrolment_node, "load_recognizer", lambda *_, **__: None)
    monkeypatch.setattr(enrolment_node, "EnrolmentService", lambda *_: None)
    monkeypatch.setattr(rospy, "Service", lambda *_: None)
    fake = SimpleNamespace(is_shutdown=lambda: False, resolve_name=lambda name: f"/{name}")
    monkeypatch.setattr(topic_source, "rospy", fake)
    voice = load_voice_config()
    topic = replace(voice.audio.topic, lost_after=0.01)
    voice = replace(voice, audio=replace(voice.audio, topic=topic))
    monkeypatch.setattr(enrolment_node, "_settings", lambda: (voice, None))
    return known


def test_takes_share_one_subscription_and_hear_only_what_comes_while_they_go_on(known):
    node = EnrolmentNode()
    before = len(known.callbacks)
    for _ in range(3):
        known.say(0)  # between takes
        sound = node._listen()
        with pytest.raises(AudioError, match="no sound on /voice_assist/audio"):
            next(sound)
    subscribe = topic_source.TopicSource.__enter__

    def subscribe_and_say(source):
        result = subscribe(source)
        known.say(10 * BLOCK)
        return result

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(topic_source.TopicSource, "__enter__", subscribe_and_say)
        assert next(node._listen()).stamp == pytest.approx(100.0 + 10 * BLOCK / RATE)
    assert len(known.callbacks) == before


def test_strangers_are_named_each_second_until_ros_ends(monkeypatch, known):
    ended, rests = iter([False, False, True]), []
    monkeypatch.setattr(rospy, "init_node", lambda *_, **__: None)
    monkeypatch.setattr(rospy, "is_shutdown", lambda: next(ended))
    monkeypatch.setattr(rospy, "spin", lambda: None)
    monkeypatch.setattr(rospy.rostime, "wallsleep", rests.append)
    monkeypatch.setattr(enrolment_node, "starting", lambda *_, **__: nullcontext())
    enrolment_node.main()
    assert (known.statuses, rests) == (2, [1.0, 1.0])
