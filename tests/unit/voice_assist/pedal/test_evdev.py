# SPDX-License-Identifier: BSD-3-Clause
"""Input devices by name, and their events, here from a pipe in place of a device."""

import errno
import itertools
import os
import struct
import threading
from contextlib import suppress

import pytest

from typed_config import load_yaml
from voice_assist.config import CONFIG_DIR
from voice_assist.config.pedal import pedal_config
from voice_assist.pedal import evdev
from voice_assist.pedal.evdev import (
    EVENT,
    DeviceMissingError,
    EvdevReader,
    EventsLostError,
    devices,
    find,
)
from voice_assist.pedal.pedals import Pedals, Send


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
    with pytest.raises(DeviceMissingError, match="there are: none"):
        find(wanted, names / "nowhere")


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

    writer = threading.Thread(target=write, daemon=True)
    writer.start()
    seen = []
    with EvdevReader(pipe) as reader, pytest.raises(OSError, match=words):
        seen.extend(reader)
    writer.join(10.0)
    assert seen == [{"button 48": 1.0}, {"axis 1": 200.0}, *news]


def test_a_loss_of_events_is_another_error_than_that_of_the_device(tmp_path):
    pipe = tmp_path / "event1"
    pipe.write_bytes(EVENT.pack(1, 2, 0, 3, 0))
    with EvdevReader(pipe) as reader, pytest.raises(EventsLostError):
        next(iter(reader))


# A device that reports which keys are pressed, by a pipe whose ioctl is made up.


def bits(length, codes):
    """Bytes in which the bits of some codes are set."""
    made = bytearray(length)
    for code in codes:
        made[code // 8] |= 1 << code % 8
    return bytes(made)


@pytest.fixture
def read(tmp_path, monkeypatch):
    """News of a device of which some keys are pressed when it is opened, then some events come."""

    def read(pressed, *events, axes=(), keys=range(768)):
        states = {  # by request of the kernel
            0x80604518: bits(96, pressed),  # EVIOCGKEY(96)
            0x80604521: bits(96, keys),  # EVIOCGBIT(EV_KEY, 96)
            0x80084523: bits(8, dict(axes)),  # EVIOCGBIT(EV_ABS, 8)
        }

        def ioctl(file, request, argument):
            if request in states:
                return states[request]
            if request == 0x80184550:  # EVIOCGABS(16) of the kernel: value, least, most and more
                return struct.pack("6i", dict(axes)[16], -1, 1, 0, 0, 0)
            if request == 0x8018454F:  # EVIOCGABS(15): the kernel gives 0 without that axis, too
                return bytes(24)
            return 0

        monkeypatch.setattr(evdev.fcntl, "ioctl", ioctl)
        pipe = tmp_path / "event1"
        pipe.write_bytes(b"".join(EVENT.pack(1, 2, *event) for event in events))
        seen = []
        with EvdevReader(pipe, ["axis 15", "axis 16"]) as reader, suppress(DeviceMissingError):
            read.inputs = reader.inputs()
            seen.extend(reader)
        return seen

    return read


def test_the_first_news_are_which_keys_are_pressed_already(read):
    first, *later = read([0, 48, 767], (1, 48, 0))
    assert len(first) == 768
    down = [name for name, value in first.items() if value]
    assert down == ["button 0", "button 48", "button 767"]
    assert later == [{"button 48": 0.0}]


def test_the_state_at_the_start_is_of_the_inputs_that_the_device_has(read):
    first, *_ = read([48], axes=[(16, 1)], keys=[48, 49])
    assert first == {"button 48": 1.0, "button 49": 0.0, "axis 16": 1.0}
    assert read.inputs == set(first)


def test_news_have_the_time_of_their_event_and_the_state_at_the_start_none(tmp_path, monkeypatch):
    monkeypatch.setattr(evdev.fcntl, "ioctl", lambda *_: bits(96, range(768)))
    pipe = tmp_path / "event1"
    pipe.write_bytes(EVENT.pack(1700000000, 250000, 1, 48, 1))
    with EvdevReader(pipe) as reader:
        news = iter(reader)
        stamps = [(next(news), reader.stamp)[1] for _ in range(2)]
    assert stamps == [0.0, 1700000000.25]


def actions(source, news):
    """What a pedal that is bound to one input makes of news, and its remarks."""
    binding = {"input": source, "above": 0.5, "does": "command", "command": "tense"}
    file = load_yaml(CONFIG_DIR / "pedal.yaml")
    time = itertools.count()  # [s] one reading after the other
    pedals = Pedals(pedal_config({**file, "bindings": [binding]}), lambda: next(time))
    pedals.found()
    return [action for one in news for action in pedals.take(one)], pedals.remarks


@pytest.mark.parametrize(
    ("pressed", "sent"),
    [([], [Send("tense", "button 48")]), ([48], []), ([49], [Send("tense", "button 48")])],
)
def test_the_first_press_counts_where_the_key_was_up_when_the_device_was_found(read, pressed, sent):
    found, remarks = actions("button 48", read(pressed, (1, 48, 1)))
    assert found == sent
    assert len(remarks) == int(49 in pressed)  # which does nothing


@pytest.mark.parametrize(("value", "sent"), [(0, [Send("tense", "axis 16")]), (1, [])])
def test_the_first_press_of_an_axis_counts_where_it_was_at_rest_before(read, value, sent):
    news = read([], (3, 16, 1), axes=[(16, value)])
    assert news[0]["axis 16"] == value
    assert actions("axis 16", news)[0] == sent


@pytest.mark.parametrize(
    ("number", "words"),
    [
        (errno.EBUSY, "another program has taken it"),
        (errno.ENODEV, "No such device"),
        (errno.ENOTTY, None),
        (errno.EINVAL, None),
    ],
)
def test_a_device_that_another_program_has_taken_is_not_read(tmp_path, monkeypatch, number, words):
    def ioctl(file, request, argument):
        raise OSError(number, os.strerror(number))

    closed = []
    monkeypatch.setattr(evdev.fcntl, "ioctl", ioctl)
    monkeypatch.setattr(evdev.os, "close", closed.append)
    pipe = tmp_path / "event1"
    pipe.write_bytes(b"")
    reader = EvdevReader(pipe, ["axis 16"])
    if words is None:
        with reader, pytest.raises(DeviceMissingError, match="the device ends"):
            assert reader.inputs() == set()
            next(iter(reader))
    else:
        with pytest.raises(OSError, match=words):
            reader.__enter__()
    assert closed.count(reader._file) == 1  # other threads close files of theirs
    monkeypatch.undo()
    os.close(reader._file)
