# SPDX-License-Identifier: BSD-3-Clause
"""Sound from a topic: what is no sound is refused with the reason, and the node goes on hearing."""

import genpy
import pytest
import rospy

from voice_assist.config import TopicConfig
from voice_assist.msg import AudioChunk
from voice_assist.ros import topic_source
from voice_assist.ros.topic_source import TopicSource


def chunk(rate=16_000, count=512, stamp=1000.0, first=0):
    message = AudioChunk(rate=rate, first_sample=first, samples=[7] * count)
    message.header.stamp = genpy.Time.from_sec(stamp)
    return message


@pytest.fixture
def source():
    troubles = []
    one = TopicSource(TopicConfig(name="audio_in", lost_after=1.0), troubles.append, print)
    one.troubles = troubles
    return one


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        (chunk(rate=0), "0 Hz, allowed: 8000 to 192000 Hz"),
        (chunk(rate=2**32 - 1), "allowed: 8000 to 192000 Hz"),
        (chunk(count=8001), "0.5 s of sound in one message"),
        (chunk(stamp=0.5), "allowed: 1 to 4e"),
        (chunk(stamp=4.2e9), "allowed: 1 to 4e"),
    ],
)
def test_a_chunk_that_is_no_sound_is_refused_and_the_next_is_heard(source, bad, words):
    source._enqueue(bad)
    source._enqueue(chunk())
    assert source._next() is None
    assert words in source.troubles[-1]
    assert len(source._next().samples) == 512
    assert source.troubles[-1] == ""


def test_a_chunk_without_a_stamp_gets_that_of_its_arrival(source):
    before = rospy.Time.now()
    source._enqueue(chunk(stamp=0.0))
    assert before <= source._next().header.stamp <= rospy.Time.now()


def test_chunks_without_end_are_not_kept_without_end(source):
    for first in range(topic_source._QUEUE + 10):
        source._enqueue(chunk(count=1, first=first))
    assert source._queue.qsize() == topic_source._QUEUE


@pytest.mark.parametrize("jump", [2**64 - 1, 10**9, 0])
def test_a_stream_that_jumps_goes_on_with_frames_in_order(source, monkeypatch, jump):
    for first in (1000, jump, jump):
        source._enqueue(chunk(first=first, stamp=1000.0))
    monkeypatch.setattr(topic_source.rospy, "is_shutdown", lambda: source._queue.empty())
    numbers = [frame.first_sample for frame in source]
    assert numbers == sorted(numbers) and numbers[-1] < 3 * 3600 * 16_000
