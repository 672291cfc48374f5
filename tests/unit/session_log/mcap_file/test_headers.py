# SPDX-License-Identifier: BSD-3-Clause
import pytest

from session_log.mcap_file.headers import read_header, starts_with_header
from support.message_classes import class_of, definition_of, serialise


@pytest.mark.parametrize(
    ("definition", "expected"),
    [
        ("Header header\nstring kind", True),
        ("# words\n\nstd_msgs/Header head # first", True),
        ("uint8 OK=0\nHeader header", True),
        ("string name\nHeader header", False),
        ("# Header header\nfloat64 x", False),
        ("", False),
    ],
)
def test_the_first_field_shows_whether_there_is_a_header(definition, expected):
    assert starts_with_header(definition) is expected


def test_sequence_and_stamp_are_read_as_ros_serialises_them():
    message = class_of("rst_control/Event")(kind="accepted")
    message.header.seq, message.header.stamp.secs, message.header.stamp.nsecs = 7, 1_700_000_000, 5
    assert starts_with_header(definition_of("rst_control/Event"))
    assert read_header(serialise(message)) == (7, 1_700_000_000_000_000_005)


def test_a_message_too_short_for_a_header_has_none():
    assert read_header(b"\1\2\3") is None
