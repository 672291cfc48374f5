# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest
import soundfile
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.unit.voice_assist.support.fake_speech import quiet_frame
from voice_assist.audio.channels import mix, plain
from voice_assist.audio.resample import Resampler
from voice_assist.audio.source import FRAME, Framer, GapWatch, level_db
from voice_assist.audio.wav_file import WavFile
from voice_assist.errors import AudioError
from voice_assist.types import RATE, frozen_samples


def sine(rate, seconds=1.0, frequency=440.0):
    return 0.5 * np.sin(2 * np.pi * frequency * np.arange(round(seconds * rate)) / rate)


class FakeTime:
    """A clock that only waiting moves."""

    def __init__(self):
        self.now = 50.0
        self.waits = []

    def __call__(self):
        return self.now

    def wait(self, seconds):
        self.waits.append(seconds)
        self.now += seconds


@settings(max_examples=60)
@given(st.lists(st.integers(0, 1500), max_size=12))
def test_frames_are_the_stream_whatever_the_blocks(sizes):
    stream = (np.arange(sum(sizes)) % 32768).astype(np.int16)
    framer, given_frames, start = Framer(), [], 0
    for size in sizes:
        given_frames += framer.push(stream[start : start + size], 10.0 + start / RATE)
        start += size
    given_frames += framer.flush()
    assert [f.first_sample for f in given_frames] == [FRAME * i for i in range(len(given_frames))]
    for frame in given_frames:
        assert len(frame.samples) == FRAME
        assert frame.stamp == pytest.approx(10.0 + frame.first_sample / RATE, abs=1e-6)
    joined = np.concatenate([f.samples for f in given_frames]) if given_frames else np.zeros(0)
    np.testing.assert_array_equal(joined[: len(stream)], frozen_samples(stream))
    assert not joined[len(stream) :].any()


def test_frames_recorded_as_16_bit_sound_come_back_unchanged():
    sound = np.random.default_rng(0).uniform(-1.2, 1.2, 5 * FRAME)
    first = np.concatenate([f.samples for f in Framer().push(sound, 0.0)])
    recorded = np.rint(first * 32767).astype(np.int16)
    again = np.concatenate([f.samples for f in Framer().push(recorded, 0.0)])
    np.testing.assert_array_equal(again, first)


def test_a_gap_moves_the_index_of_the_next_frame_and_none_can_be_written_to():
    framer = Framer()
    list(framer.push(np.zeros(700), 0.0))
    framer.skip(300)
    (frame,) = framer.push(np.zeros(512), 1.0)
    assert (frame.first_sample, frame.stamp) == (1000, 1.0)
    with pytest.raises(ValueError, match="read-only"):
        frame.samples[0] = 1.0


def test_gaps_are_noticed_and_counted():
    gaps = map(GapWatch(), map(quiet_frame, (1024, 1536, 4000, 0, 512)))
    assert list(gaps) == [None, None, 4000 - 2048, 0, None]


def test_levels_in_decibels():
    assert level_db(np.ones(100, np.float32)) == pytest.approx(0.0)
    assert level_db(np.full(100, 0.1, np.float32)) == pytest.approx(-20.0, abs=1e-3)
    assert [level_db(np.zeros(n, np.float32)) for n in (100, 0)] == [-100.0] * 2


@pytest.mark.parametrize("rate", [8000, 11_025, 22_050, 32_000, 44_100, 48_000, 96_000])
def test_resampling_by_blocks_keeps_pitch_level_and_length(rate):
    resample, sound = Resampler(rate), sine(rate)
    blocks = [resample(block.astype(np.float32)) for block in np.array_split(sound, 37)]
    heard = np.concatenate([*blocks, resample(np.zeros(0, np.float32), is_last=True)])
    assert len(heard) == pytest.approx(RATE, abs=10)
    middle = heard[2000:14_000]
    spectrum = np.abs(np.fft.rfft(middle * np.hanning(len(middle))))
    assert spectrum.argmax() * RATE / len(middle) == pytest.approx(440.0, abs=2.0)
    assert level_db(middle) == pytest.approx(level_db(sound.astype(np.float32)), abs=0.1)


def test_sound_at_16_khz_is_left_as_it_is_and_a_rate_of_no_device_refused():
    sound = sine(RATE).astype(np.float32)
    np.testing.assert_array_equal(Resampler(RATE)(sound), sound)
    with pytest.raises(AudioError, match="sample rate 0 Hz"):
        Resampler(0)


def test_channels_are_averaged_and_integers_scaled_once():
    both = np.array([[32767, -32767], [32767, 32767]], np.int16)
    np.testing.assert_allclose(mix(both, plain(2)), [0.0, 1.0])
    assert frozen_samples(np.array([32767], np.int16))[0] == 1.0
    with pytest.raises(ValueError, match="mono"):
        frozen_samples(np.zeros((2, 2)))


@pytest.mark.parametrize("speed", [1.0, 4.0])
def test_a_recording_is_played_in_time(tmp_path, speed):
    path = tmp_path / "sound.wav"
    soundfile.write(path, sine(RATE), RATE)
    time = FakeTime()
    with WavFile(path, time, time.wait, speed=speed) as source:
        for number, frame in enumerate(source, 1):
            assert time.now == pytest.approx(50.0 + number * FRAME / RATE / speed)
            assert frame.first_sample == (number - 1) * FRAME
            assert frame.stamp == pytest.approx(time.now - FRAME / RATE)
    assert time.now == pytest.approx(50.0 + 32 * FRAME / RATE / speed)


def test_after_a_recording_that_was_entered_silence_goes_on(tmp_path):
    path = tmp_path / "sound.wav"
    soundfile.write(path, sine(RATE, 0.1), RATE)
    with pytest.raises(AudioError, match="enter the source first"):
        next(iter(WavFile(path, FakeTime(), lambda _: None)))
    time = FakeTime()
    with WavFile(path, time, time.wait, then_silence=True) as source:
        heard = [frame for frame, _ in zip(source, range(50), strict=False)]
    assert [f.first_sample for f in heard] == [FRAME * i for i in range(50)]
    assert heard[1].samples.any() and not heard[-1].samples.any()
