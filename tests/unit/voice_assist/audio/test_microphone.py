# SPDX-License-Identifier: BSD-3-Clause
import itertools
import threading

import numpy as np
import pytest

from support.waiting import wait_until
from voice_assist.audio.capture import microphone as microphone_module
from voice_assist.audio.capture.microphone import Microphone
from voice_assist.audio.capture.portaudio import Device, choose
from voice_assist.config import load_voice_config
from voice_assist.errors import DeviceError
from voice_assist.types import RATE

MONITOR = Device("pulse:hdmi.monitor", RATE, True)
RETRY = load_voice_config().audio.microphone.retry_after  # [s]
USB, BUILT_IN = Device("USB Headset: Audio (hw:1,0)", 48_000, False), Device("pulse", 44_100, True)


class FakeStream:
    is_closed = False

    def __init__(self, rate):
        self.rate = rate

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


def samples(seconds):
    return round(seconds * RATE)


def listen(sound, device="", attempts=5, lost_after=0.2, on_wait=None):
    """All frames and reports until the given number of waits for a device are over."""
    reports = []
    left = [attempts]

    def pause(seconds):
        if seconds:
            left[0] -= 1
            sound.now += seconds
            if on_wait:
                on_wait(microphone, attempts - left[0])
        return left[0] <= 0

    config = load_voice_config(
        audio__microphone__device=device,
        audio__microphone__lost_after=lost_after,
        audio__microphone__open_within=lost_after,
    ).audio.microphone
    with Microphone(config, sound, sound.clock, pause, reports.append) as microphone:
        frames = list(microphone)
    return frames, reports


def test_what_the_device_gives_comes_out_in_frames_stamped_as_it_was_captured():
    frames, reports = listen(FakeSound([[BUILT_IN]], [blocks(10)]), attempts=1)
    assert [f.first_sample for f in frames] == [512 * i for i in range(10)]
    stamps = [100.0 + i * 512 / RATE for i in range(10)]
    assert [f.stamp for f in frames] == pytest.approx(stamps, abs=1e-6)
    assert frames[0].samples[0] == pytest.approx(1000 / 32767)
    assert reports[0] == ""
    assert "no sound for 0.2 s" in reports[1]


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


def test_what_comes_after_a_loss_is_not_joined_though_the_clock_was_set_back():
    set_back = (-1000.0, np.ones(512, np.int16), False)
    sound = FakeSound([[BUILT_IN]], [blocks(4), [set_back, *blocks(3)]])
    frames, _ = listen(sound, attempts=2)
    after = 4 * 512 + RATE // 10
    assert [f.first_sample for f in frames[4:]] == [after + 512 * i for i in range(4)]


def test_the_gap_runs_from_the_last_block_heard_to_the_first_after_the_loss():
    first = (0.25, np.ones(512, np.int16), False)
    sound = FakeSound([[BUILT_IN]], [blocks(4), [], [first, *blocks(3)]])
    frames, _ = listen(sound, attempts=3)
    after = 4 * 512 + samples(2 * RETRY + 0.25)
    assert [f.first_sample for f in frames[4:]] == [after + 512 * i for i in range(4)]


def test_a_device_that_opens_and_gives_nothing_stays_reported():
    sound = FakeSound([[BUILT_IN]], [blocks(1), [], [], blocks(1)])
    _, reports = listen(sound, attempts=4)
    assert [bool(words) for words in reports] == [False, True, True, True, False, True]


def test_a_device_that_never_gives_a_block_is_never_reported_as_right():
    _, reports = listen(FakeSound([[BUILT_IN]], [[], []]), attempts=2)
    assert ["no sound for 0.2 s" in words for words in reports] == [True, True]


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
    assert frames[3].first_sample == 3 * 512 + samples(5.0 + 512 / RATE + RETRY)


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
    with Microphone(config, sound, sound.clock, over.wait, lambda _: None) as microphone:
        for count, _ in enumerate(microphone, 1):
            if count == 4:
                over.set()
    assert count == 4
    assert sound.streams[0].is_closed


def test_the_whole_name_wins_over_a_part_of_another():
    devices = [Device("pulse", RATE, True), Device("pulse:surgeon.monitor", RATE, False)]
    assert choose("pulse", devices) is devices[0]
    assert choose("SURGEON.Monitor", devices) is devices[1]
    assert choose("", devices) is devices[0]
    with pytest.raises(DeviceError, match="default microphone: not found; microphones found: none"):
        choose("", [])


def test_a_name_that_fits_several_is_refused():
    devices = [Device("USB one", RATE, False), Device("USB two", RATE, True)]
    with pytest.raises(DeviceError, match="fits several"):
        choose("usb", devices)


def test_the_default_that_goes_is_waited_for_though_another_becomes_the_default():
    other = Device(USB.name, USB.rate, True)
    sound = FakeSound([[BUILT_IN, USB], [other], [other], [MONITOR], [BUILT_IN]], [blocks(4)] * 2)
    frames, reports = listen(sound, attempts=5)
    assert set(sound.opened) == {BUILT_IN.name}
    assert len(frames) == 8
    assert "'pulse': not found; microphones found: 'USB Headset" in reports[2]


def test_a_part_of_the_name_counts_until_one_is_opened():
    other = Device("USB Webcam", RATE, False)
    sound = FakeSound([[USB], [other], [USB, other]], [blocks(4)] * 2)
    frames, _ = listen(sound, "usb", attempts=3)
    assert set(sound.opened) == {USB.name}
    assert len(frames) == 8


@pytest.mark.parametrize("name", ["", "hdmi", "pulse"])
def test_a_monitor_is_taken_only_by_a_name_that_says_so(name):
    with pytest.raises(DeviceError, match=r"not found; microphones found: 'pulse:hdmi\.monitor'"):
        choose(name, [MONITOR])
    assert choose("hdmi.monitor", [MONITOR]) is MONITOR


class Person:
    """Chooses microphones, each as soon as the one before was answered."""

    def __init__(self, *names):
        self._names, self.answers = names, []

    def ask(self, microphone):
        self._microphone = microphone
        threading.Thread(target=self._ask, daemon=True).start()
        self.wait(0)

    def _ask(self):
        for name in self._names:
            self.answers.append(self._microphone.change(name))

    def wait(self, answered):
        """Until so many were answered, and the next is asked or answered too."""
        wait_until(lambda: len(self.answers) >= answered, "an answer")
        if answered < len(self._names):
            asked = self._microphone._choices
            wait_until(lambda: not asked.empty() or len(self.answers) > answered, "a choice")


def test_a_person_may_choose_another_and_a_wrong_name_changes_nothing():
    person = Person("no such", "usb")

    def on_wait(microphone, number):
        if number == 1:
            person.ask(microphone)
        else:
            person.wait(min(number - 1, 2))

    sound = FakeSound([[BUILT_IN, USB]], [blocks(4)] * 3)
    listen(sound, attempts=4, on_wait=on_wait)
    assert sound.opened[0] == BUILT_IN.name and sound.opened[-1] == USB.name
    assert person.answers[0].startswith("microphone 'no such': not found") and not person.answers[1]


def test_a_chosen_one_that_is_busy_is_named_so_and_the_one_before_goes_on(monkeypatch):
    person = Person("usb")
    sound = FakeSound([[BUILT_IN, USB]], [blocks(4)] * 2)
    opened = sound.open

    def busy(device, on_block):
        if device.name == USB.name:
            sound.opened.append(device.name)
            raise DeviceError("busy", device.name)
        return opened(device, on_block)

    monkeypatch.setattr(sound, "open", busy)

    def on_wait(microphone, number):
        if number == 1:
            person.ask(microphone)

    listen(sound, attempts=3, on_wait=on_wait)
    person.wait(1)
    assert sound.opened == [BUILT_IN.name, USB.name, BUILT_IN.name]
    assert "busy" in person.answers[0]


def test_a_working_microphone_is_left_for_the_chosen_one_at_once_with_a_gap():
    sound = FakeSound([[BUILT_IN, USB]], [blocks(10), blocks(4)])
    config = load_voice_config(audio__microphone__open_within=0.2).audio.microphone
    person, heard = Person("usb"), []
    with Microphone(config, sound, sound.clock, bool, lambda _: None) as microphone:
        for frame in microphone:
            heard.append(frame.first_sample)
            if len(heard) == 3:
                person.ask(microphone)
    person.wait(1)
    assert sound.opened == [BUILT_IN.name, USB.name]
    assert len(heard) == 7 and heard[3] == 10 * 512  # seven more blocks came meanwhile


def test_a_choice_whose_caller_was_refused_for_lack_of_an_answer_is_not_made_later(monkeypatch):
    monkeypatch.setattr(microphone_module, "_CHOICE_TIME", 0.01)
    answers = []

    def on_wait(microphone, number):
        if number == 1:
            answers.append(microphone.change("usb"))

    sound = FakeSound([[BUILT_IN, USB]], [blocks(4)] * 2)
    listen(sound, attempts=3, on_wait=on_wait)
    assert "the microphone before stays" in answers[0]
    assert set(sound.opened) == {BUILT_IN.name}
