# SPDX-License-Identifier: BSD-3-Clause
"""Two microphones of one model: after a loss neither is opened until a person chooses."""

import pytest

from tests.unit.voice_assist.audio.test_microphone import (
    BUILT_IN,
    USB,
    FakeSound,
    Person,
    blocks,
    listen,
)
from voice_assist.audio.capture.microphone import Microphone
from voice_assist.audio.capture.portaudio import Device, has_twin
from voice_assist.config import KeptMicrophoneConfig, load_voice_config
from voice_assist.errors import DeviceError
from voice_assist.types import RATE

TWIN = Device(USB.name.replace("hw:1", "hw:2"), USB.rate, False)
BOTH = [BUILT_IN, USB, TWIN]
WORDS = "was lost, and another of its model is or was there"


@pytest.mark.parametrize(
    "later",
    [[BOTH], [[USB]], [[TWIN], [USB]]],
    ids=["both are back", "one is back", "the other, then one"],
)
def test_after_a_loss_one_of_two_of_a_model_is_not_opened_silently(later):
    frames, reports = listen(FakeSound([BOTH, *later], [blocks(4)] * 2), USB.name)
    assert len(frames) == 4
    assert WORDS in reports[-1] and "set_microphone" in reports[-1]


def test_another_of_the_model_that_comes_only_while_the_first_is_lost_counts_too():
    sound = FakeSound([[USB], [], [TWIN], [USB]], [blocks(4)] * 2)
    frames, reports = listen(sound, USB.name)
    assert len(frames) == 4 and WORDS in reports[-1]


@pytest.mark.parametrize("chosen", [USB, TWIN])
def test_the_one_that_a_person_chooses_is_opened(chosen):
    person, sound = Person(chosen.name), FakeSound([BOTH], [blocks(4)] * 2)

    def on_wait(microphone, number):
        if number == 2:
            person.ask(microphone)

    frames, _ = listen(sound, USB.name, on_wait=on_wait)
    person.wait(1)
    assert person.answers == [""]
    assert sound.opened == [USB.name, chosen.name] and len(frames) == 8


def test_one_without_another_of_its_model_is_opened_again():
    other = Device("USB Webcam: Audio (hw:2,0)", RATE, False)
    sound = FakeSound([[USB, other], [other], [USB, other]], [blocks(4)] * 2)
    frames, _ = listen(sound, USB.name)
    assert set(sound.opened) == {USB.name} and len(frames) == 8


@pytest.mark.parametrize("name", ["no such", BUILT_IN.name])
def test_a_choice_that_fails_leaves_the_one_before_that_was_not_lost(monkeypatch, name):
    sound, person, heard = FakeSound([BOTH], [blocks(10), blocks(4)]), Person(name), []
    opened = sound.open

    def busy(device, on_block):
        if device is BUILT_IN:
            raise DeviceError("busy", device.name)
        return opened(device, on_block)

    monkeypatch.setattr(sound, "open", busy)
    config = load_voice_config(
        audio__microphone__device=USB.name, audio__microphone__open_within=0.2
    ).audio.microphone
    with Microphone(config, sound, sound.clock, bool, lambda _: None) as microphone:
        stream = iter(microphone)
        heard += [next(stream) for _ in range(3)]
        person.ask(microphone)
        heard += list(stream)  # until a pause, such as after a busy one
    person.wait(1)
    assert person.answers[0] and sound.opened[0] == USB.name
    assert microphone.name == USB.name
    assert sound.opened == [USB.name] * (2 if name == "no such" else 1)


def test_after_a_crash_the_kept_one_waits_for_a_choice_where_there_are_two():
    given = {**vars(load_voice_config().audio.microphone), "device": USB.name}
    for devices, opened in ((BOTH, []), ([BUILT_IN, USB], [USB.name])):
        sound, reports = FakeSound([devices], [blocks(4)]), []
        config = KeptMicrophoneConfig(**{**given, "open_within": 0.2, "lost_after": 0.2})
        with Microphone(config, sound, sound.clock, bool, reports.append) as microphone:
            list(microphone)
        assert sound.opened == opened
        assert (WORDS in reports[0]) is not opened


@pytest.mark.parametrize(
    ("name", "other", "is_twin"),
    [
        ("X: USB Audio (hw:1,0)", "X: USB Audio (hw:2,0)", True),
        ("X: USB Audio (hw:1,0)", "X: USB Audio (hw:1,0)", False),
        ("X: USB Audio (hw:1,0)", "Y: USB Audio (hw:2,0)", False),
        ("X: USB Audio (hw:1,0)", "X: USB Audio", True),
        ("pulse:alsa_input.usb-X-00.mono", "pulse:alsa_input.usb-X-00.mono.2", True),
        ("pulse:alsa_input.usb-X-00.mono", "pulse:alsa_input.usb-X-00.3.mono", True),
        ("pulse:alsa_input.usb-X-00.mono", "pulse:alsa_input.usb-X-01.mono", False),
        ("pulse:alsa_input.usb-X_1-00.mono", "pulse:alsa_input.usb-X_2-00.mono", False),
        ("pulse", "default", False),
    ],
)
def test_what_differs_only_by_its_slot_is_of_one_model(name, other, is_twin):
    devices = [Device(one, RATE, False) for one in (name, other)]
    assert has_twin(name, devices) is is_twin
    assert has_twin(other, devices) is is_twin
