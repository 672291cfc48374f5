# SPDX-License-Identifier: BSD-3-Clause
"""Messages decoded at once are what the decoder makes of each by itself."""

import struct

import numpy as np
import pytest

from session_log.mcap_file.bulk import Batch
from session_log.mcap_file.decoder import Decoder
from support.message_classes import class_of, serialise, source_of

NUMBERS = {
    "/joint_states": ("header.stamp", "position", "effort"),
    "/rst_control/state": ("header.stamp", "state", "phase", "halted", "tension", "rcm_error"),
    "/robot/tension": ("header.frame_id", "wrench.force.x", "wrench.force.z"),
    "/voice_assist/audio": ("first_sample", "samples"),
    "/voice_assist/mode": ("mode", "reason"),
}


def value_of(content, name):
    for part in name.split("."):
        content = getattr(content, part)
    return content.secs * 10**9 + content.nsecs if hasattr(content, "nsecs") else content


@pytest.mark.parametrize("topic", NUMBERS)
def test_every_message_of_a_session_is_read_as_the_decoder_reads_it(story, topic):
    mine = [m for m in story[1] if m.source.topic == topic]
    source, decoder = mine[0].source, Decoder()
    batch = Batch(source.datatype, source.definition, [m.data for m in mine])
    one_by_one = [decoder.decode(m) for m in mine]
    for name in NUMBERS[topic]:
        column = batch.column(name)
        assert len(column) == len(mine) and not batch.unfit
        for k in range(0, len(mine), 1 + len(mine) // 300):
            assert np.array_equal(column[k], value_of(one_by_one[k], name)), (name, k)


def event(**fields):
    return serialise(class_of("rst_control/Event")(**fields))


def test_messages_of_one_size_and_other_layouts_are_distinguished():
    source = source_of("/e", "rst_control/Event")
    payloads = [
        event(kind="ab", command="c"),
        event(kind="a", command="bc"),
        event(kind="xy", command="z"),
    ]
    batch = Batch(source.datatype, source.definition, payloads)
    assert len({len(p) for p in payloads}) == 1
    assert list(batch.column("kind")) == ["ab", "a", "xy"]
    assert list(batch.column("command")) == ["c", "bc", "z"]


def test_a_duration_below_zero_and_a_late_time_are_read():
    payload = struct.pack("<iiII", -1, 500_000_000, 2**32 - 1, 0)
    batch = Batch("test_msgs/T", "duration d\ntime t", [payload])
    assert batch.column("d").tolist() == [-500_000_000]
    assert batch.column("t").tolist() == [(2**32 - 1) * 10**9]


def test_arrays_of_several_lengths_are_objects():
    source = source_of("/j", "sensor_msgs/JointState")
    kind = class_of("sensor_msgs/JointState")
    payloads = [serialise(kind(position=list(range(n)))) for n in (2, 3, 2)]
    column = Batch(source.datatype, source.definition, payloads).column("position")
    assert [list(row) for row in column] == [[0, 1], [0, 1, 2], [0, 1]]


def test_messages_that_do_not_fit_are_named_and_the_others_read():
    source = source_of("/e", "rst_control/Event")
    whole = event(kind="ab", command="c")
    lies = whole[:12] + b"\xff\xff\xff\x7f" + whole[16:]
    batch = Batch(source.datatype, source.definition, [whole, whole[:9], whole + b"x", lies, b""])
    assert sorted(batch.unfit) == [1, 2, 3, 4] and list(batch.column("kind")) == ["ab"]
    with pytest.raises(KeyError):
        batch.column("no such field")


def test_of_nothing_that_fits_there_is_nothing():
    source = source_of("/e", "rst_control/Event")
    assert len(Batch(source.datatype, source.definition, [b"", b"x"]).column("kind")) == 0
