# SPDX-License-Identifier: BSD-3-Clause
"""Messages of 500 a second that stay bytes: read when they are needed, written in one piece."""

from __future__ import annotations

import time
from io import BytesIO

from geometry_msgs.msg import WrenchStamped
from sensor_msgs.msg import JointState


class _Raw:
    """A message left as bytes, with the time at which it came."""

    raw = b""
    arrived = 0.0  # [s] steady clock
    ahead = 0.0  # [s] wall clock less steady clock at that time, where the subscriber notes it

    def __init__(self) -> None:
        """Make none of the fields."""

    def deserialize(self, buff: bytes) -> _Raw:
        """Keep the bytes."""
        self.raw, self.arrived = buff, time.monotonic()
        return self


class RawJointState(_Raw, JointState):
    """sensor_msgs/JointState as it arrived."""


class RawWrench(_Raw, WrenchStamped):
    """geometry_msgs/WrenchStamped as it arrived."""


class _Written:
    """A message that is bytes already, its header included."""

    _has_header = False

    def __init__(self, raw: bytes) -> None:
        self.raw = raw

    def serialize(self, buff: BytesIO) -> None:
        """Write the bytes."""
        buff.write(self.raw)


class WrittenJointState(_Written, JointState):
    """sensor_msgs/JointState to be sent."""


class WrittenWrench(_Written, WrenchStamped):
    """geometry_msgs/WrenchStamped to be sent."""
