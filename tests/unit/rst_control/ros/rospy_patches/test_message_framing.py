# SPDX-License-Identifier: BSD-3-Clause
import struct

from hypothesis import given
from hypothesis import strategies as st

from rst_control.ros.rospy_patches.message_framing import (
    LONGEST_HEADER,
    LONGEST_MESSAGE,
    MAX_PLACES,
    NEWS_PERIOD,
    Refusals,
    announced,
    has_whole_header,
    split_messages,
)


def framed(message):
    return struct.pack("<I", len(message)) + message


@given(st.lists(st.binary(max_size=50), max_size=10), st.binary(max_size=3))
def test_messages_that_were_joined_come_apart_again(messages, tail):
    whole, rest = split_messages(b"".join(framed(m) for m in messages) + tail)
    assert whole == messages and rest == tail


@given(st.binary(max_size=300))
def test_any_bytes_are_cut_without_loss(data):
    whole, rest = split_messages(data)
    assert b"".join(framed(m) for m in whole) + rest == data
    assert announced(rest) == 0 or announced(rest) > len(rest) - 4


@given(st.lists(st.binary(max_size=50), max_size=5), st.integers(0, 300))
def test_what_comes_in_two_pieces_is_read_as_if_it_came_in_one(messages, cut):
    data = b"".join(framed(m) for m in messages)
    first, rest = split_messages(data[:cut])
    second, rest = split_messages(rest + data[cut:])
    assert first + second == messages and rest == b""


def test_only_as_many_are_taken_as_are_asked_for():
    data = framed(b"stop") + framed(b"tense")
    assert split_messages(data, 1) == ([b"stop"], framed(b"tense"))


def test_a_message_that_is_too_long_is_left_with_its_length():
    long = framed(bytes(LONGEST_MESSAGE + 1))
    whole, rest = split_messages(framed(b"good") + long + framed(b"after"))
    assert whole == [b"good"] and announced(rest) == LONGEST_MESSAGE + 1
    assert split_messages(framed(bytes(LONGEST_MESSAGE)))[0] == [bytes(LONGEST_MESSAGE)]


def test_a_handshake_is_waited_for_and_what_is_none_is_not():
    header = framed(framed(b"callerid=/a"))
    assert has_whole_header(header) is True
    assert all(has_whole_header(header[:n]) is None for n in range(1, len(header)))
    assert has_whole_header(b"") is False
    assert has_whole_header(b"GET / HTTP/1.1\r\n") is False
    assert has_whole_header(struct.pack("<I", LONGEST_HEADER + 1)) is False
    assert has_whole_header(bytes(4)) is False


def test_refusals_are_reported_seldom_with_the_number_kept_back():
    now = [0.0]
    refusals = Refusals(lambda: now[0])
    assert refusals.count("/topic", "bad") == "bad"
    assert [refusals.count("/topic", "bad") for _ in range(1000)] == [""] * 1000
    assert refusals.count("/another", "worse") == "worse"
    now[0] = NEWS_PERIOD
    assert refusals.count("/topic", "bad") == "bad; and 1000 more before it"


def test_refusals_in_places_without_end_are_not_remembered_without_end():
    refusals = Refusals(lambda: 0.0)
    reported = [refusals.count(f"/topic{n}", "bad") for n in range(1000)]
    assert sum(words != "" for words in reported) <= MAX_PLACES + 1
