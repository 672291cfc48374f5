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
    before = rospy.get_time()
    source._enqueue(chunk(stamp=0.0, count=8000))
    end = source._next().header.stamp.to_sec() + 0.5
    assert before - 1e-6 <= end <= rospy.get_time() + 1e-6


def clocks(monkeypatch, ends, lateness, is_wallclock=True, unstamped=()):
    """What is reported of the clocks as chunks come that ended so late [s]."""
    found = []
    config = TopicConfig(name="audio_in", lost_after=1.0)
    source = TopicSource(config, print, print, found.append)
    monkeypatch.setattr(rospy.rostime, "is_wallclock", lambda: is_wallclock)
    for number, (end, late) in enumerate(zip(ends, lateness, strict=True)):
        monkeypatch.setattr(topic_source.rospy, "get_time", lambda now=end + late: now)
        source._enqueue(chunk(stamp=0.0 if number in unstamped else end - 0.032))
    return found


ENDS = [1000.0 + 0.032 * n for n in range(100)]  # [s] of chunks


@pytest.mark.parametrize(
    ("late", "words"),
    [
        (-1.3, "the clock of the sound's host is 1.30 s ahead, allowed 0.2 s: run chrony"),
        (-0.25, "0.25 s ahead, allowed 0.2 s"),
        (0.6, "the sound comes 0.60 s late, or the clock of its host is behind, allowed 0.3 s"),
    ],
)
def test_a_clock_that_differs_is_named_after_a_second_in_words_that_stay(monkeypatch, late, words):
    found = clocks(monkeypatch, ENDS, [late + 0.02 * (n % 2) for n in range(100)])
    assert found[:30] == [""] * 30
    assert words in found[-1] and len(set(found[35:])) == 1


@pytest.mark.parametrize("late", [-0.15, 0.0, 0.25])
def test_clocks_that_nearly_agree_are_no_trouble(monkeypatch, late):
    assert set(clocks(monkeypatch, ENDS, [late] * 100)) == {""}


def test_one_late_message_is_no_trouble_nor_a_heap_of_them_after_a_stall(monkeypatch):
    lateness = [0.0] * 100
    lateness[40] = 1.0
    assert set(clocks(monkeypatch, ENDS, lateness)) == {""}
    stalled = [max(1002.0 - end, 0.0) if end > 1000.3 else 0.0 for end in ENDS]
    assert set(clocks(monkeypatch, ENDS, stalled)) == {""}


def test_seldom_messages_are_not_judged_by_one_that_is_late(monkeypatch):
    ends = [1000.0 + 3.0 * n for n in range(10)]
    assert set(clocks(monkeypatch, ends, [0.5 * (n == 5) for n in range(10)])) == {""}


def test_clocks_that_agree_again_are_no_trouble_any_more(monkeypatch):
    found = clocks(monkeypatch, ENDS, [-0.5] * 40 + [0.0] * 60)
    assert found[35] and found[-1] == ""


@pytest.mark.parametrize("late", [-0.5, 0.6])
def test_clocks_are_no_trouble_once_the_sound_comes_without_stamps(monkeypatch, late):
    found = clocks(monkeypatch, ENDS, [late] * 100, unstamped=range(40, 100))
    assert found[35] and found[-1] == ""


def test_stamps_ahead_stay_named_between_chunks_without_stamps(monkeypatch):
    found = clocks(monkeypatch, ENDS, [-0.5] * 100, unstamped=range(0, 100, 2))
    assert set(found[:30]) == {""} and "0.50 s ahead" in found[-1]


def test_stamps_of_a_simulated_clock_are_not_compared(monkeypatch):
    assert clocks(monkeypatch, ENDS, [-1e9] * 100, is_wallclock=False) == []


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


@pytest.mark.parametrize(
    ("pause", "lost"), [(0.0, 0), (0.2, 0), (0.5, 8000), (-30.0, 0), (1e5, 3600 * 16_000)]
)
def test_a_publisher_that_pauses_without_counting_is_not_joined(source, monkeypatch, pause, lost):
    source._enqueue(chunk(first=1000))
    source._enqueue(chunk(first=1512, stamp=1000.032 + pause))
    monkeypatch.setattr(topic_source.rospy, "is_shutdown", lambda: source._queue.empty())
    assert [frame.first_sample for frame in source] == pytest.approx([0, 512 + lost], abs=1)
