# SPDX-License-Identifier: BSD-3-Clause
"""Sound without stamps: its format is judged by its amount, gaps and silence are reported."""

from dataclasses import replace

import numpy as np
import pytest

from voice_assist.audio.capture.unstamped import SoundBlock, UnstampedStream
from voice_assist.config import load_voice_config

CONFIG = load_voice_config().audio.audio_data
TICK = 0.032  # [s] of sound in a message
RAMP = (np.arange(512) - 256).astype("<i2")
SOUND = RAMP.tobytes()


def informed():
    """A stream whose publisher reports its format."""
    stream = UnstampedStream(CONFIG)
    stream.inform(1, 16000, "S16LE", "WAVE")
    return stream


def taken(stream, seconds, data=SOUND, every=TICK, start=100.0):
    """What a stream makes of messages that come for so many seconds."""
    count = round(seconds / every)
    return [stream.take(data, start + n * every) for n in range(count)]


def test_right_sound_is_heard_after_a_second_as_it_was_sent():
    results = taken(UnstampedStream(CONFIG), 3.0)
    first = next(i for i, r in enumerate(results) if r != "")
    assert 0.9 < first * TICK < 1.2 and all(isinstance(r, SoundBlock) for r in results[first:])
    block = results[first]
    assert block.samples.dtype == np.int16 and block.samples[:, 0].tolist() == RAMP.tolist()
    assert block.lost == 0.0 and block.stamp == pytest.approx(100.0 + first * TICK - TICK)


def test_a_publisher_that_reports_its_format_is_heard_at_once():
    assert isinstance(informed().take(SOUND, 5.0), SoundBlock)


@pytest.mark.parametrize(
    ("reported", "named"),
    [
        ((2, 16000, "S16LE", "wave"), "2 x 16000 Hz S16LE wave"),
        ((1, 44100, "S16LE", "wave"), "1 x 44100 Hz"),
        ((1, 16000, "F32LE", "wave"), "F32LE"),
        ((1, 16000, "S16LE", "mp3"), "mp3"),
    ],
)
def test_another_format_that_is_reported_is_named_and_never_heard(reported, named):
    stream = UnstampedStream(CONFIG)
    stream.inform(*reported)
    results = taken(stream, 3.0)
    assert all(isinstance(r, str) and named in r for r in results)
    assert "allowed: 1 x 16000 Hz S16LE wave; it is not heard" in results[0]


@pytest.mark.parametrize("drift", [2e-4, -2e-4])
def test_a_clock_that_is_a_little_off_loses_nothing_in_an_hour(drift):
    blocks = taken(informed(), 3600.0, every=TICK * (1.0 + drift))
    assert sum(block.lost for block in blocks) == 0.0


def test_what_is_lost_on_the_way_is_lost_also_where_the_clock_is_off():
    stream = informed()
    taken(stream, 60.0, every=TICK * 1.0002)
    block = stream.take(SOUND, 100.0 + 60.0 + 1.0)
    assert block.lost == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize(("share", "every"), [(0.05, 0.02), (0.2, 0.02), (0.2, 0.064)])
def test_sound_that_is_lost_all_the_time_is_reported_as_lost(share, every):
    stream, data = informed(), bytes(2 * round(16000 * every))
    lost, reported = 0.0, 0.0
    for n in range(round(60.0 / every)):
        if n > 0 and n * every % 1.0 < share:
            lost += every
        else:
            reported += stream.take(data, 100.0 + n * every).lost
    assert reported == pytest.approx(lost, abs=0.3)


@pytest.mark.parametrize(
    ("bytes_per_second", "ratio"), [(16_000, "0.50"), (64_000, "2.00"), (88_200, "2.76")]
)
def test_another_amount_is_named_and_not_heard(bytes_per_second, ratio):
    """Compressed by a half; two channels, or twice the rate; 44.1 kHz."""
    data = bytes(2 * round(bytes_per_second * TICK / 2))
    results = taken(UnstampedStream(CONFIG), 8.0, data)
    assert not any(isinstance(r, SoundBlock) for r in results)
    assert f"{ratio} times real time" in results[-1] and "compressed" in results[-1]


@pytest.mark.parametrize(
    ("data", "named"),
    [
        (b"", "0 bytes"),
        (b"abc", "3 bytes in a message, allowed: a multiple of 2"),
        (bytes(32_000), "1.0 s of sound in one message, allowed: 0.5 s"),
    ],
)
def test_a_message_that_is_no_sound_is_named(data, named):
    assert named in UnstampedStream(CONFIG).take(data, 1.0)


@pytest.mark.parametrize("is_reported", [False, True])
def test_messages_that_went_missing_are_a_gap_of_their_length(is_reported):
    stream = informed() if is_reported else UnstampedStream(CONFIG)
    taken(stream, 2.0)
    end = 100.0 + (round(2.0 / TICK) - 1) * TICK
    after = stream.take(SOUND, end + 0.5 + TICK)
    assert after.lost == pytest.approx(0.5)
    assert stream.take(SOUND, end + 0.5 + 2 * TICK).lost == 0.0


def test_messages_that_come_late_and_in_a_heap_are_no_gap():
    stream = informed()
    taken(stream, 2.0)
    blocks = [stream.take(SOUND, 102.0 + 0.16) for _ in range(5)]
    blocks += [stream.take(SOUND, 102.16 + n * TICK) for n in range(1, 9)]
    assert sum(b.lost for b in blocks) == 0.0


@pytest.mark.parametrize("stall", [0.3, 0.5, 0.8])
def test_a_loss_soon_after_a_stall_of_this_process_is_reported_whole(stall):
    stream, times = informed(), [100.0 + n * TICK for n in range(1000)]
    times = [max(at, 105.0 + stall) if at > 105.0 else at for at in times]  # a heap of them
    times = [at for at in times if not 125.0 <= at < 125.448]
    late = [(at, stream.take(SOUND, at).lost) for at in times]
    lost = [amount for at, amount in late if at > 120.0 and amount > 0.0]
    assert lost == [pytest.approx(0.448, abs=0.04)]


@pytest.mark.parametrize(("is_reported", "judging"), [(True, 0.0), (False, 1.0)])
def test_a_silence_is_a_gap_of_its_length_with_what_is_not_heard_after_it(is_reported, judging):
    stream = informed() if is_reported else UnstampedStream(CONFIG)
    end = 100.0 + (len(taken(stream, 2.0)) - 1) * TICK
    stream.forget()
    blocks = [b for b in taken(stream, 2.0, start=end + 20.0) if b != ""]
    assert blocks[0].lost == pytest.approx(20.0 + judging, abs=0.1)
    assert sum(block.lost for block in blocks[1:]) == 0.0


@pytest.mark.parametrize("is_reported", [True, False])
def test_after_a_silence_nothing_is_joined_though_the_clock_was_set_back(is_reported):
    stream = informed() if is_reported else UnstampedStream(CONFIG)
    taken(stream, 2.0)
    stream.forget()
    blocks = [b for b in taken(stream, 2.0, start=50.0) if b != ""]
    assert blocks[0].lost == pytest.approx(0.1)
    assert sum(block.lost for block in blocks[1:]) == 0.0


def test_sound_that_is_refused_for_a_while_is_a_gap():
    stream = UnstampedStream(CONFIG)
    assert isinstance(taken(stream, 3.0)[-1], SoundBlock)
    assert isinstance(taken(stream, 6.0, 2 * SOUND, start=103.0)[-1], str)
    blocks = [b for b in taken(stream, 20.0, start=109.0) if isinstance(b, SoundBlock)]
    refused = blocks[0].stamp - 103.0
    assert sum(block.lost for block in blocks) == pytest.approx(refused, abs=3.0)
    assert blocks[0].lost > 5.0


@pytest.mark.parametrize(
    ("name", "values", "heard"),
    [
        ("S32LE", np.array([1 << 30, -(1 << 31)], "<i4"), [0.5, -1.0]),
        ("F32LE", np.array([0.25, np.nan, np.inf, 7.0], "<f4"), [0.25, 0.0, 0.0, 1.0]),
    ],
)
def test_other_types_become_sound_within_full_scale(name, values, heard):
    stream = UnstampedStream(replace(CONFIG, sample_format=name))
    stream.inform(1, 16000, name, "wave")
    assert stream.take(values.tobytes(), 1.0).samples[:, 0].tolist() == heard


def test_channels_lie_beside_each_other():
    stream = UnstampedStream(replace(CONFIG, channels=2))
    stream.inform(2, 16000, "S16LE", "wave")
    assert stream.take(SOUND, 1.0).samples.shape == (256, 2)
