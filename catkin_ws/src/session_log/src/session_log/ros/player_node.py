# SPDX-License-Identifier: BSD-3-Clause
"""Publishes a recording again at its own pace, for viewers such as rviz that open no files.

It needs a roscore of its own: on that of a running system it would speak for the robot, so it
refuses where a topic of the recording has a publisher already.
"""

from __future__ import annotations

import argparse
import sys
import time
from io import BytesIO

import rosgraph
import rospy

from session_log.errors import SessionLogError
from session_log.mcap_file.reader import SessionReader
from session_log.types import Message, MessageSource

URDF_TOPIC = "/robot_description"
CONNECT_TIME = 1.0  # [s] for viewers to connect before the first message


class RawMessage(rospy.AnyMsg):
    """Bytes of a message, published as they were recorded."""

    def __init__(self, data: bytes = b"") -> None:
        super().__init__()
        self._buff = data

    def serialize(self, buff: BytesIO) -> None:
        """Write the bytes."""
        buff.write(self._buff)


class RecordingPlayer:
    """Publishes the messages of one recording.

    Args:
        reader: The recording.
        rate: Recorded over real time.
    """

    def __init__(self, reader: SessionReader, rate: float) -> None:
        self._reader, self._rate = reader, rate
        self._out: dict[str, rospy.Publisher] = {}
        self.count = 0

    def prepare(self) -> None:
        """Announce every topic, and set the recorded robot_description."""
        for message in self._reader.messages():
            if message.source.topic not in self._out:
                self._out[message.source.topic] = _publisher(message.source)
                if message.source.topic == URDF_TOPIC:
                    rospy.set_param(URDF_TOPIC, message.data[4:].decode("utf-8", "replace"))

    def play(self) -> None:
        """Publish all, each message when it is due."""
        begin: tuple[int, float] | None = None
        for message in self._reader.messages():
            if begin is None:
                begin = message.log_time, time.monotonic()
            due = begin[1] + (message.log_time - begin[0]) * 1e-9 / self._rate
            time.sleep(max(due - time.monotonic(), 0.0))
            if rospy.is_shutdown():
                return
            self._publish(message)

    def _publish(self, message: Message) -> None:
        publisher = self._out.get(message.source.topic)
        if publisher is not None:
            publisher.publish(publisher.data_class(message.data))
            self.count += 1


def _publisher(source: MessageSource) -> rospy.Publisher:
    facts = {
        "_type": source.datatype,
        "_md5sum": source.md5sum,
        "_full_text": source.definition,
        "_has_header": False,  # the recorded one stays as it is
    }
    kind = type("Recorded", (RawMessage,), facts)
    latch = source.is_latched or source.topic in (URDF_TOPIC, "/tf_static")
    return rospy.Publisher(source.topic, kind, queue_size=1000, latch=latch)


def _busy(reader: SessionReader) -> list[str]:
    """Topics of the recording that someone else publishes at this moment."""
    published = {t for t, _ in rosgraph.Master(rospy.get_name()).getPublishedTopics("")}
    recorded = {m.source.topic for m in reader.messages()}
    return sorted(published & recorded - {"/rosout", "/rosout_agg"})


def main() -> None:
    """Play the recording that is named on the command line."""
    parser = argparse.ArgumentParser(prog="play", description=__doc__)
    parser.add_argument("session", help="folder of the session, or its MCAP file")
    parser.add_argument("--rate", type=float, default=1.0, help="recorded over real time")
    options = parser.parse_args(rospy.myargv(sys.argv)[1:])
    if not 0.0 < options.rate <= 100.0:
        parser.error(f"--rate is {options.rate:g}, allowed: above 0, up to 100")
    rospy.init_node("player", anonymous=True)
    try:
        reader = SessionReader(options.session)
        busy = _busy(reader)
        if busy:
            sys.exit(
                f"someone publishes {', '.join(busy[:3])} already; play on a roscore of its own"
            )
        player = RecordingPlayer(reader, options.rate)
        player.prepare()
        time.sleep(CONNECT_TIME)
        player.play()
    except SessionLogError as error:
        sys.exit(str(error))
    print(f"{player.count} messages played")
