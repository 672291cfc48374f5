# SPDX-License-Identifier: BSD-3-Clause
"""Devices by PortAudio, here made up: what fails is named, and tried anew."""

import sys
from types import ModuleType, SimpleNamespace

import pytest

from voice_assist.audio.capture import portaudio
from voice_assist.audio.capture.portaudio import Device, PortAudio
from voice_assist.errors import DeviceError


class PortAudioError(Exception):
    pass


class FakePortAudio(ModuleType):
    """The functions of sounddevice that are used; `fails` names one that raises."""

    PortAudioError = PortAudioError
    default = SimpleNamespace(device=(1, 0))

    def __init__(self):
        super().__init__("sounddevice")
        self._initialized, self.fails, self.opened = 1, "", []
        self.error = PortAudioError("Unanticipated host error")
        self.rates = [16_000, 48_000]

    def _terminate(self):
        if not self._initialized:
            raise PortAudioError("PortAudio not initialized")
        self._initialized -= 1

    def _initialize(self):
        self._raise("_initialize")
        self._initialized += 1

    def query_devices(self):
        self._raise("query_devices")
        names = (("HDMI", 0), ("USB", 1), ("Mixer", 128))
        return [
            {"name": n, "index": i, "max_input_channels": c, "default_samplerate": 48_000.0}
            for i, (n, c) in enumerate(names)
        ]

    def InputStream(self, samplerate, **given):
        self.opened.append((samplerate, given["channels"], given["blocksize"]))
        if samplerate not in self.rates:
            raise PortAudioError("Invalid sample rate")
        return SimpleNamespace(start=lambda: None, close=lambda ignore_errors: None)

    def _raise(self, name):
        if self.fails == name:
            raise self.error


@pytest.fixture
def library(monkeypatch):
    fake = FakePortAudio()
    monkeypatch.setitem(sys.modules, "sounddevice", fake)
    monkeypatch.setattr(portaudio, "pulse_sources", tuple)
    return fake


def test_microphones_are_those_that_have_inputs(library):
    wanted = [Device("USB", 48_000, True, 1), Device("Mixer", 48_000, False, 2)]
    assert PortAudio().devices() == PortAudio().devices() == wanted


@pytest.mark.parametrize("fails", ["_initialize", "query_devices"])
@pytest.mark.parametrize("error", [PortAudioError("host error"), ValueError("can't decode byte")])
def test_a_search_that_fails_is_named_and_the_next_one_finds_them_again(library, fails, error):
    backend = PortAudio()
    library.fails, library.error = fails, error
    for _ in range(2):
        with pytest.raises(DeviceError, match=f"devices cannot be searched .{error}"):
            backend.devices()
    library.fails = ""
    assert [device.name for device in backend.devices()] == ["USB", "Mixer"]


@pytest.mark.parametrize(("rates", "opened"), [([16_000], 16_000), ([48_000], 48_000)])
def test_a_device_is_opened_at_16_khz_or_at_its_own_rate(library, rates, opened):
    library.rates = rates
    stream = PortAudio().open(Device("USB", 48_000, True, 1), lambda *_: None)
    assert stream.rate == opened and library.opened[-1] == (opened, 1, 512 * opened // 16_000)


def test_a_device_that_cannot_be_opened_is_named(library):
    library.rates = []
    with pytest.raises(DeviceError, match=r"'USB': cannot be opened \(Invalid sample rate\)"):
        PortAudio().open(Device("USB", 48_000, True, 1), lambda *_: None)


def test_without_the_library_the_package_to_install_is_named(monkeypatch):
    class Missing:
        @staticmethod
        def find_spec(name, *_):
            if name == "sounddevice":
                raise OSError("PortAudio library not found")

    monkeypatch.delitem(sys.modules, "sounddevice", raising=False)
    monkeypatch.setattr(sys, "meta_path", [Missing, *sys.meta_path])
    with pytest.raises(DeviceError, match=r"library not found\); install libportaudio2"):
        PortAudio()
