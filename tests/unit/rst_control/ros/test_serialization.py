# SPDX-License-Identifier: BSD-3-Clause
import struct
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rst_control.ros.common.serialization import (
    BadMessage,
    JointStateReader,
    read_force,
    write_joint_state,
)
from rst_control.types import JOINTS

POSITION, VELOCITY = np.arange(10.0), np.arange(10.0) * 0.1


def message(second=1, names=JOINTS, position=POSITION, velocity=VELOCITY):
    return write_joint_state((7, second, 500_000_000), names, position, velocity)


def wrench(force):
    return struct.pack("<4I", 1, 2, 3, 9) + b"base_link" + struct.pack("<6d", *force, 0, 0, 0)


def test_what_was_written_is_read_back():
    sample = JointStateReader(JOINTS)(message())
    assert sample.stamp == 1.5
    np.testing.assert_array_equal(sample.position, POSITION)
    np.testing.assert_array_equal(sample.velocity, VELOCITY)


def test_joints_in_another_order_are_put_right_message_after_message():
    reader = JointStateReader(JOINTS)
    for second in (1, 2):
        raw = message(second, JOINTS[::-1], POSITION[::-1], VELOCITY[::-1])
        np.testing.assert_array_equal(reader(raw).position, POSITION)


def test_joints_that_are_not_ours_are_left_out():
    names = ("other", *JOINTS)
    raw = message(1, names, np.append(99.0, POSITION), np.append(99.0, VELOCITY))
    np.testing.assert_array_equal(JointStateReader(JOINTS)(raw).position, POSITION)


@pytest.mark.parametrize(
    ("raw", "words"),
    [
        (message(names=JOINTS[:-1], position=POSITION[:-1]), "without joint_finger_right"),
        (message(position=POSITION[:-1]), "9 values of position"),
        (message(velocity=VELOCITY[:-1]), "9 values of velocity"),
        (message(position=np.where(POSITION == 3.0, np.nan, POSITION)), "not a number"),
        (message(velocity=np.where(POSITION == 3.0, np.inf, VELOCITY)), "not a number"),
        (message()[:-100], "cut short"),
        (b"", "cut short"),
    ],
)
def test_what_cannot_be_used_is_refused_with_the_reason(raw, words):
    with pytest.raises(BadMessage, match=words):
        JointStateReader(JOINTS)(raw)


def test_stamps_must_advance_until_the_reader_is_reset():
    reader = JointStateReader(JOINTS)
    reader(message(second=2))
    for second in (2, 1):
        with pytest.raises(BadMessage, match="out of order"):
            reader(message(second=second))
    reader.reset()
    assert reader(message(second=1)).stamp == 1.5


@given(st.binary(max_size=400))
def test_any_bytes_are_read_or_refused(raw):
    for read in (JointStateReader(JOINTS), read_force):
        with suppress(BadMessage):
            read(raw)


PLACES = [message().index(v.tobytes()) + 8 * k for v in (POSITION, VELOCITY) for k in range(10)]
NO_NUMBERS = [struct.pack("<d", value) for value in (np.nan, np.inf, -np.inf)]
DAMAGES = st.one_of(
    st.tuples(st.integers(0, 400), st.binary(min_size=1, max_size=8)),
    st.tuples(st.sampled_from(PLACES), st.sampled_from(NO_NUMBERS)),
)


@given(DAMAGES)
def test_any_damage_to_a_message_is_read_or_refused(drawn):
    (where, damage), good = drawn, message()
    raw = good[:where] + damage + good[where + len(damage) :]
    with suppress(BadMessage):
        sample = JointStateReader(JOINTS)(raw)
        assert np.isfinite(sample.position).all() and np.isfinite(sample.velocity).all()


def test_force_is_read_and_must_be_a_number():
    np.testing.assert_array_equal(read_force(wrench((1.0, 2.0, 3.0))), [1.0, 2.0, 3.0])
    with pytest.raises(BadMessage, match="not a number"):
        read_force(wrench((1.0, float("nan"), 3.0)))
