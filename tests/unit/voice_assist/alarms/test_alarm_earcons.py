# SPDX-License-Identifier: BSD-3-Clause
"""The waveforms themselves: pulses, pitch, level, silence, and how far they are apart."""

import itertools

import numpy as np
import pytest

from voice_assist.alarms.earcons import BELOW_HIGH_DB, PATTERNS, samples_of
from voice_assist.alarms.types import Earcon, Priority
from voice_assist.types import RATE

VOLUME = -6.0  # [dB]
PULSES = {Priority.HIGH: {10}, Priority.MEDIUM: {3}, Priority.LOW: {1, 2}}
LENGTHS = {  # [s] of a pulse, IEC 60601-1-8 table 3
    Priority.HIGH: (0.075, 0.200),
    Priority.MEDIUM: (0.125, 0.250),
    Priority.LOW: (0.125, 0.250),
}
ALARMS = [e for e in Earcon if PATTERNS[e].priority is not Priority.INFORMATION]


def pulses(sound):
    """Begin and end [s] of each stretch louder than a hundredth of the peak."""
    block = 32  # 2 ms
    count = len(sound) // block
    level = np.abs(sound[: count * block]).reshape(count, block).max(axis=1)
    edges = np.flatnonzero(np.diff(np.r_[0, level > 0.01 * level.max(), 0])) * block / RATE
    return list(zip(edges[::2], edges[1::2], strict=True))


def spectrum(sound, begin, end):
    part = sound[round(begin * RATE) : round(end * RATE)]
    power = np.abs(np.fft.rfft(part * np.hanning(len(part)), 4 * RATE)) ** 2
    return np.fft.rfftfreq(4 * RATE, 1 / RATE), power


def fundamental(sound, begin, end):
    frequency, power = spectrum(sound, begin, end)
    return float(frequency[power.argmax()])


@pytest.mark.parametrize("earcon", Earcon)
def test_rhythm_and_pitch_are_those_of_the_pattern_and_peaks_as_the_priority_asks(earcon):
    sound, pattern = samples_of(earcon, VOLUME), PATTERNS[earcon]
    found = pulses(sound)
    assert len(found) == len(pattern.starts)
    for (begin, end), start, pitch in zip(found, pattern.starts, pattern.pitches, strict=True):
        assert begin == pytest.approx(start, abs=0.008)
        assert end - begin == pytest.approx(pattern.pulse, abs=0.016)
        assert fundamental(sound, begin, end) == pytest.approx(pitch, rel=0.02)
    peak = 20 * np.log10(np.abs(sound).max())
    assert peak == pytest.approx(VOLUME - BELOW_HIGH_DB[pattern.priority], abs=0.01)


@pytest.mark.parametrize("earcon", ALARMS)
def test_alarms_have_the_usual_pulses_pitches_and_harmonics(earcon):
    sound, pattern = samples_of(earcon, VOLUME), PATTERNS[earcon]
    assert len(pattern.starts) in PULSES[pattern.priority]
    low, high = LENGTHS[pattern.priority]
    assert low <= pattern.pulse <= high
    for begin, end in pulses(sound):
        pitch = fundamental(sound, begin, end)
        assert 150.0 <= pitch <= 1000.0
        frequency, power = spectrum(sound, begin, end)
        near = [power[np.abs(frequency - n * pitch) < 15.0].max() for n in range(1, 5)]
        assert 4 * pitch < 4000.0
        assert 10 * np.log10(max(near) / min(near)) < 15.0  # four harmonics of similar strength


def test_volume_only_scales():
    loud, soft = (samples_of(Earcon.STOP, v) for v in (-6.0, -26.0))
    np.testing.assert_allclose(0.1 * loud, soft, atol=1e-6)


@pytest.mark.parametrize("earcon", Earcon)
def test_no_click_at_begin_end_or_between_pulses(earcon):
    sound = samples_of(earcon, 0.0)
    assert abs(sound[0]) < 1e-3 and abs(sound[-1]) < 1e-3
    found, millisecond = pulses(sound), RATE // 1000
    for begin, end in found:
        first, last = round(begin * RATE), round(end * RATE)
        assert np.abs(sound[first : first + millisecond]).max() < 0.1
        assert np.abs(sound[last - millisecond : last]).max() < 0.1
    gaps = [b - a for (_, a), (b, _) in itertools.pairwise(found)]
    assert all(gap >= 0.03 for gap in gaps)


@pytest.mark.parametrize("earcon", ALARMS)
def test_pulses_rise_as_slowly_as_is_usual(earcon):
    """10 to 90 % of the peak within 10 to 20 % of the pulse; here of its envelope."""
    sound, pattern = samples_of(earcon, 0.0), PATTERNS[earcon]
    envelope = np.abs(sound[: round(pattern.pulse * RATE)])
    period = round(RATE / pattern.pitches[0])
    smooth = np.array([envelope[max(0, i - period) : i + 1].max() for i in range(len(envelope))])
    rise = (np.argmax(smooth > 0.9 * smooth.max()) - np.argmax(smooth > 0.1 * smooth.max())) / RATE
    assert 0.04 <= rise / pattern.pulse <= 0.25


def bands(earcon):
    """Level over time (20 ms) and frequency (third octaves), each sound of unit energy."""
    sound = np.zeros(round(2.6 * RATE))
    part = samples_of(earcon, VOLUME)
    sound[: len(part)] = part
    frames = sound.reshape(-1, RATE // 50)
    power = np.abs(np.fft.rfft(frames * np.hanning(frames.shape[1]), axis=1)) ** 2
    frequency = np.fft.rfftfreq(frames.shape[1], 1 / RATE)
    edges = 200.0 * 2.0 ** (np.arange(15) / 3.0)
    octaves = [(frequency >= a) & (frequency < b) for a, b in itertools.pairwise(edges)]
    grid = np.sqrt(np.stack([power[:, octave].sum(axis=1) for octave in octaves]))
    return grid / np.linalg.norm(grid)


def likeness(first, second):
    """Largest correlation of two sounds over all shifts in time; 1: the same."""
    one, two = bands(first), bands(second)
    shifts = range(-one.shape[1] + 1, one.shape[1])
    return max(float((one * np.roll(two, k, axis=1)).sum()) for k in shifts)


def test_a_sound_is_like_itself():
    assert likeness(Earcon.STOP, Earcon.STOP) == pytest.approx(1.0)


@pytest.mark.parametrize(("first", "second"), itertools.combinations(Earcon, 2))
def test_any_two_sounds_are_far_apart(first, second):
    assert likeness(first, second) < 0.9


def test_a_stop_falls_and_a_fault_rises():
    stop, fault = PATTERNS[Earcon.STOP].pitches, PATTERNS[Earcon.FAULT_MEDIUM].pitches
    assert stop == tuple(sorted(stop, reverse=True)) and fault == tuple(sorted(fault))
