# SPDX-License-Identifier: BSD-3-Clause
"""The messages of each of the simulator's topics are numbered without gaps."""

import struct

import numpy as np
from sensor_msgs.msg import JointState

from rst_control.ros.simulator.messages import Stamper, StateWriter
from rst_control.simulation.physics import JointReading
from rst_control.types import JOINTS

STILL = np.zeros(len(JOINTS))


def number(message):
    return struct.unpack("<I", message.raw[:4])[0]


def test_each_topic_counts_its_own_messages():
    writer = StateWriter(Stamper(is_real_time=False))
    reading = JointReading(STILL, STILL, STILL)
    seen = {"joints": [], "rest": [], "wrench": []}
    for step in range(6):
        seen["joints"].append(number(writer.joints(0.0, reading)))
        if step % 2 == 0:
            seen["rest"].append(number(writer.rest(0.0, STILL)))
        if step % 3 == 0:
            seen["wrench"].append(number(writer.wrench(0.0, np.zeros(3))))
    assert seen == {"joints": [1, 2, 3, 4, 5, 6], "rest": [1, 2, 3], "wrench": [1, 2]}


def test_where_the_joints_are_held_is_said_without_speed():
    held = np.arange(len(JOINTS)) / 10.0
    written = StateWriter(Stamper(is_real_time=False)).rest(2.5, held)
    message = JointState().deserialize(written.raw)
    assert tuple(message.name) == JOINTS and message.header.stamp.to_sec() == 2.5
    assert np.array_equal(message.position, held) and not np.any(message.velocity)
