# SPDX-License-Identifier: BSD-3-Clause
"""Values that recorder, reader and report pass to each other."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final, NamedTuple

MESSAGE_ENCODING: Final = "ros1"  # of every message that this package records
SCHEMA_ENCODING: Final = "ros1msg"  # of its definition
URDF_TOPIC: Final = "/robot_description"  # std_msgs/String; as a parameter ROS has the same


@dataclass(frozen=True)
class MessageSource:
    """One publisher's connection on one topic, as its connection header describes it."""

    topic: str  # resolved name, such as /joint_states
    datatype: str  # such as sensor_msgs/JointState
    md5sum: str
    definition: str  # full text, nested definitions included
    publisher: str = ""  # name of the publishing node
    is_latched: bool = False
    message_encoding: str = MESSAGE_ENCODING
    schema_encoding: str = SCHEMA_ENCODING
    _hash: int = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Hash once: counters look a source up for each of its messages."""
        names = (self.topic, self.md5sum, self.publisher, self.is_latched)
        object.__setattr__(self, "_hash", hash(names))

    def __hash__(self) -> int:
        return self._hash

    @property
    def is_ros1(self) -> bool:
        """Whether its messages are those of ROS 1; no others can be decoded or copied."""
        return (self.message_encoding, self.schema_encoding) == (MESSAGE_ENCODING, SCHEMA_ENCODING)


class Message(NamedTuple):
    """One recorded message, still as bytes; an hour of session holds six millions."""

    source: MessageSource
    data: bytes
    log_time: int  # [ns] since 1970, when it was received
    sequence: int  # counts the source's messages from 1; a gap means loss
    publish_time: int = 0  # [ns] since 1970; 0: the same as the log time


@dataclass(frozen=True)
class Damage:
    """A stretch of a file that could not be read."""

    offset: int  # [B] from the start of the file
    length: int  # [B]
    what: str

    def __str__(self) -> str:
        return f"{self.length} bytes at {self.offset}: {self.what}"


@dataclass
class TopicCount:
    """How much of one topic a recording holds."""

    datatype: str
    messages: int = 0
    size: int = 0  # [B] of message data
    missing: int = 0  # gaps in the sequence: received but not in the file
    first: int = 0  # [ns] log time, by the clock as it was when the recording began
    last: int = 0  # [ns] likewise
    publishers: set[str] = field(default_factory=set)

    @property
    def rate(self) -> float:
        """Mean rate [Hz]; zero for fewer than two messages."""
        span = (self.last - self.first) * 1e-9
        return (self.messages - 1) / span if self.messages > 1 and span > 0 else 0.0
