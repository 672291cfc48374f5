# SPDX-License-Identifier: BSD-3-Clause
"""The microphone of a session outlives a crash, and a person may choose another."""

from types import SimpleNamespace

import pytest

from rst_control.host.respawn import RESTART
from support.waiting import wait_until
from voice_assist.audio.capture.microphone import Microphone
from voice_assist.audio.capture.portaudio import Device
from voice_assist.config import load_voice_config
from voice_assist.errors import DeviceError
from voice_assist.ros import microphone_service, node_settings
from voice_assist.types import RATE


@pytest.fixture
def master(monkeypatch):
    """What a master keeps, and the services announced to it."""
    kept, services = {}, {}
    fake = SimpleNamespace(
        set_param=kept.__setitem__,
        get_param=kept.get,
        has_param=kept.__contains__,
        loginfo=lambda *_: None,
        Service=lambda name, _, serve: services.update({name: serve}),
    )
    for module in (microphone_service, node_settings):
        monkeypatch.setattr(module, "rospy", fake)
    monkeypatch.setattr(node_settings, "launch_settings", lambda **_: {})
    return SimpleNamespace(kept=kept, services=services)


def microphone(name):
    config = load_voice_config(audio__microphone__device=name).audio.microphone
    return Microphone(config, None, lambda: 0.0, bool, lambda _: None)


def test_a_node_that_crashed_listens_to_the_same_microphone(master, monkeypatch):
    service = microphone_service.MicrophoneService(microphone("pulse:headset"))
    assert service.note_name() == "pulse:headset"
    wait_until(lambda: master.kept, "the name on the master")
    assert node_settings.node_settings().audio.microphone.device == ""
    monkeypatch.setenv(RESTART, "1")
    assert node_settings.node_settings().audio.microphone.device == "pulse:headset"


def test_after_a_crash_a_microphone_whose_name_only_holds_the_kept_one_is_not_opened(
    master, monkeypatch
):
    master.kept[node_settings.OPENED] = name = "pulse:alsa_input.usb-X.analog-stereo"
    monkeypatch.setenv(RESTART, "1")
    config, reports, opened = node_settings.node_settings().audio.microphone, [], []
    found = [
        [Device(f"{name}-front", RATE, True)],
        [Device(f"{name}-front", RATE, True), Device(name, RATE, False)],
    ]

    def open_device(device, _):
        opened.append(device.name)
        raise DeviceError("busy", device.name)

    backend = SimpleNamespace(devices=lambda: found.pop(0), open=open_device)
    listener = Microphone(config, backend, lambda: 0.0, lambda _: not found, reports.append)
    assert list(listener) == []
    assert "not found" in reports[0] and opened == [name]


@pytest.mark.parametrize("problem", ["", "microphone 'x': not found"])
def test_the_service_answers_what_came_of_a_choice(master, monkeypatch, problem):
    chosen = []
    monkeypatch.setattr(Microphone, "change", lambda _, name: chosen.append(name) or problem)
    microphone_service.MicrophoneService(microphone(""))
    answer = master.services["voice_assist/set_microphone"](SimpleNamespace(device="x"))
    assert (answer.success, answer.message, chosen) == (not problem, problem, ["x"])


def test_of_a_recording_no_microphone_can_be_chosen(master):
    service = microphone_service.MicrophoneService(SimpleNamespace())
    assert service.note_name() == "" and not master.services
