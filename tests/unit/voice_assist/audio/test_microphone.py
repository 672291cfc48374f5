# SPDX-License-Identifier: BSD-3-Clause
import itertools
import threading

import numpy as np
import pytest

from voice_assist.audio.microphone import Microphone
from voice_assist.audio.portaudio import Device, choose
from voice_assist.config import load_voice_config
from voice_assist.errors import DeviceError
from voice_assist.types import RATE

USB, BUILT_IN = Device("USB Headset: Audio (hw:1,0)", 48_000, False), Device("pulse", 44_100, True)


class FakeStream:
    def __init__(self, rate):
        self.rate = rate
        self.is_closed = False

    def close(self):
        self.is_closed = True


class FakeSound:
    """Devices that come and go; each open plays a list of blocks at once, then goes silent."""

    def __init__(self, device_lists, plays, rate=RATE):
        self.device_lists, self.plays, self.rate = list(device_lists), list(plays), rate
        self.opened, self.streams = [], []
        self.now = 100.0

    def clock(self):
        return self.now

    def devices(self):
        assert all(s.is_closed for s in self.streams), "searched while a stream is open"
        return self.device_lists.pop(0) if len(self.device_lists) > 1 else self.device_lists[0]

    def open(self, device, on_block):
        self.opened.append(device.name)
        if not self.plays:
            raise DeviceError("busy", device.name)
        stream = FakeStream(self.rate)
        self.streams.append(stream)
        for gap, samples, is_after_loss in self.plays.pop(0):
            self.now += gap + len(samples) / self.rate
            on_block(samples, is_after_loss)
        return stream


def blocks(count, size=512, value=1000):
    return [(0.0, np.full(size, value, np.int16), False)] * count


def listen(sound, device="", attempts=5, lost_after=0.2):
    """All frames and reports until the given number of waits for a device are over."""
    reports = []
    left = [attempts]

    def pause(seconds):
        if seconds:
            left[0] -= 1
            sound.now += seconds
        return left[0] <= 0

    config = load_voice_config(
        audio__microphone__device=device,
        audio__microphone__lost_after=lost_after,
        audio__microphone__open_within=lost_after,
    ).audio.microphone
    with Microphone(config, sound, sound.clock, pause, reports.append) as microphone:
        frames = list(microphone)
    return frames, reports


def test_what_the_device_gives_comes_out_in_frames():
    frames, reports = listen(FakeSound([[BUILT_IN]], [blocks(10)]), attempts=1)
    assert len(frames) == 10
    assert [f.first_sample for f in frames] == [512 * i for i in range(10)]
    assert frames[0].samples[0] == pytest.approx(1000 / 32767)
    assert reports[0] == ""
    assert "no sound for 0.2 s" in reports[1]


def test_stamps_are_when_the_sound_was_captured():
    frames, _ = listen(FakeSound([[BUILT_IN]], [blocks(10)]), attempts=1)
    for i, frame in enumerate(frames):
        assert frame.stamp == pytest.approx(100.0 + i * 512 / RATE, abs=1e-6)


def test_another_rate_is_resampled():
    sound = FakeSound([[BUILT_IN]], [blocks(100, 1536)], rate=48_000)
    frames, _ = listen(sound, attempts=1)
    assert len(frames) == pytest.approx(100, abs=2)


def test_a_missing_device_is_reported_with_what_exists_and_waited_for():
    sound = FakeSound([[BUILT_IN], [BUILT_IN], [BUILT_IN, USB]], [blocks(3)])
    frames, reports = listen(sound, "usb headset", attempts=3)
    assert reports[0] == "microphone 'usb headset': not found; microphones found: 'pulse'"
    assert sound.opened == [USB.name]
    assert len(frames) == 3


def test_a_lost_device_is_never_replaced_and_its_return_is_a_gap():
    here, gone = [BUILT_IN, USB], [BUILT_IN]
    sound = FakeSound([here, gone, gone, gone, here], [blocks(4), blocks(4)])
    frames, reports = listen(sound, "USB", attempts=5)
    assert set(sound.opened) == {USB.name}
    assert len(frames) == 8
    assert frames[4].first_sample > 4 * 512 + RATE
    assert "lost" in reports[1] and "microphones found: 'pulse'" in reports[1]
    assert sound.streams[0].is_closed


def test_a_device_that_cannot_be_opened_is_tried_again():
    sound = FakeSound([[BUILT_IN]], [])
    frames, reports = listen(sound, attempts=3)
    assert frames == []
    assert len(sound.opened) == 3
    assert "busy" in reports[0]


def test_a_pause_of_the_stream_counts_as_lost():
    late = (5.0, np.ones(512, np.int16), False)
    sound = FakeSound([[BUILT_IN]], [[*blocks(3), late], blocks(2)])
    frames, reports = listen(sound, attempts=2)
    assert len(frames) == 5
    assert "gave no sound for 5.0 s" in reports[1]


def test_an_overflow_leaves_a_gap():
    late = (0.1, np.ones(512, np.int16), True)
    sound = FakeSound([[BUILT_IN]], [[*blocks(3), late, *blocks(3)]])
    frames, _ = listen(sound, attempts=1)
    lost = [b.first_sample - a.first_sample - 512 for a, b in itertools.pairwise(frames)]
    assert sum(lost) == pytest.approx(0.1 * RATE, abs=200)
    assert max(lost) == sum(lost)


def test_zeros_at_the_start_are_sound():
    frames, reports = listen(FakeSound([[BUILT_IN]], [blocks(20, value=0)]), attempts=1)
    assert len(frames) == 20
    assert reports[0] == ""


def test_reading_ends_when_asked_to():
    sound = FakeSound([[BUILT_IN]], [blocks(10)])
    over = threading.Event()
    config = load_voice_config().audio.microphone
    count = 0
    with Microphone(config, sound, sound.clock, over.wait, lambda _: None) as microphone:
        for _ in microphone:
            count += 1
            if count == 4:
                over.set()
    assert count == 4
    assert sound.streams[0].is_closed


def test_the_whole_name_wins_over_a_part_of_another():
    devices = [Device("pulse", RATE, True), Device("pulse:surgeon.monitor", RATE, False)]
    assert choose("pulse", devices) is devices[0]
    assert choose("SURGEON", devices) is devices[1]
    assert choose("", devices) is devices[0]


def test_a_name_that_fits_several_is_refused():
    devices = [Device("USB one", RATE, False), Device("USB two", RATE, True)]
    with pytest.raises(DeviceError, match="fits several"):
        choose("usb", devices)


def test_without_any_microphone_the_list_says_none():
    with pytest.raises(DeviceError, match="default microphone: not found; microphones found: none"):
        choose("", [])
