# SPDX-License-Identifier: BSD-3-Clause
"""Input devices by name, and their events, here from a pipe in place of a device."""

import os
import threading
from contextlib import suppress

import pytest

from voice_assist.pedal.evdev import EVENT, DeviceMissingError, EvdevReader, devices, find


def name(folder, event, text):
    file = folder / event / "device" / "name"
    file.parent.mkdir(parents=True)
    file.write_bytes(text)


@pytest.fixture
def names(tmp_path):
    name(tmp_path, "event0", b"Power Button\n")
    name(tmp_path, "event1", b"PCsensor FootSwitch Keyboard\n")
    name(tmp_path, "event2", b"PCsensor FootSwitch Mouse\n")
    name(tmp_path, "event3", b"\xff\xfe\n")  # no text: it has no name here
    return tmp_path


def test_a_device_is_found_by_its_name_or_a_part_that_only_it_has(names):
    assert find("PCsensor FootSwitch Keyboard", names) == "event1"
    assert find("FootSwitch Mouse", names) == "event2"
    assert len(devices(names)) == 3


@pytest.mark.parametrize(("wanted", "words"), [("FootSwitch", "2 devices"), ("Olympus", "no dev")])
def test_a_name_of_none_or_of_several_is_refused_with_those_there_are(names, wanted, words):
    with pytest.raises(DeviceMissingError, match=words) as found:
        find(wanted, names)
    assert "Power Button" in str(found.value)


def test_a_machine_without_devices_says_so(tmp_path):
    with pytest.raises(DeviceMissingError, match="there are: none"):
        find("pedal", tmp_path / "nowhere")


PRESSED = [(1, 48, 1), (1, 48, 2), (4, 4, 30), (0, 0, 0), (3, 1, 200)]


@pytest.mark.parametrize(
    ("then", "news", "words"),
    [
        ([(1, 48, 0)], [{"button 48": 0.0}], "the device ends"),
        ([(0, 3, 0), (1, 48, 0)], [], "events were lost, so what is pressed is unknown"),
    ],
)
def test_events_are_read_until_the_device_is_gone_or_some_are_lost(tmp_path, then, news, words):
    pipe = tmp_path / "event1"
    os.mkfifo(pipe)
    events = [*PRESSED, *then]
    data = b"".join(EVENT.pack(1, 2, *event) for event in events)

    def write():
        with pipe.open("wb", buffering=0) as file:
            for at in range(0, len(data), 7):  # cut anywhere
                with suppress(BrokenPipeError):
                    file.write(data[at : at + 7])

    writer = threading.Thread(target=write)
    writer.start()
    seen = []
    with EvdevReader(pipe) as reader, pytest.raises(OSError, match=words):
        for one in reader:
            seen.append(one)
    writer.join()
    assert seen == [{"button 48": 1.0}, {"axis 1": 200.0}, *news]
