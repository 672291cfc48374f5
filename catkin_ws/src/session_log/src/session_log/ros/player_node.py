# SPDX-License-Identifier: BSD-3-Clause
"""Publishes a recording again at its own pace, for viewers such as rviz that open no files.

Its topics lie below a prefix, so that no node of a running system takes them for its own. Under the
recorded names it plays only where nobody publishes or hears one of them but viewers, and ends when
somebody does.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from datetime import datetime
from io import BytesIO
from typing import Any

import rospy

from session_log.errors import SessionLogError
from session_log.mcap_file.decoder import MissingField, Undecodable
from session_log.mcap_file.encoding import WrongEncoding
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.static_frames import STATIC_TOPIC, StaticFrames
from session_log.mcap_file.summary import CLOCK_STEP, ClockStep
from session_log.types import URDF_TOPIC, Message, MessageSource
from typed_config.ros.xmlrpc import FAILURES, ask_master, master_problem

PREFIX = "/played"
VIEWERS = ("/rviz", "/rosout", "/foxglove")  # beginnings of the names of nodes that move nothing
CHECK_PERIOD = 1.0  # [s] between searches for nodes that came meanwhile
CONNECT_TIME = 1.0  # [s] for viewers to connect before the first message
LONGEST_SILENCE = 10_000_000_000  # [ns] a session is never so quiet: its state comes at 50 Hz
LONGEST_SLEEP = 0.2  # [s] so that Ctrl-C ends a pause of the recording


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
        prefix: Of all topics; empty: the recorded names.
        live: Nodes of a running system on the topics that are played; not asked with a prefix.
    """

    def __init__(
        self,
        reader: SessionReader,
        rate: float,
        prefix: str,
        live: Callable[[Collection[str]], list[str]],
    ) -> None:
        self._reader, self._rate, self._prefix, self._live = reader, rate, prefix, live
        self._checked = 0.0  # [s] steady clock
        self._out: dict[str, rospy.Publisher] = {}
        self._kinds: dict[str, tuple[str, str]] = {}  # of each topic's publisher
        self._frames = StaticFrames()
        self._names: list[str] = []  # of the topics that are played
        self.count = 0

    def prepare(self) -> None:
        """Announce every topic, and set the recorded robot_description.

        A publisher has one type: of a topic that changed it, only the last is played.

        Raises:
            LiveSystem: A running system has one of the topics.
            WrongEncoding: A topic holds messages that are none of ROS 1.
        """
        counts: Counter[MessageSource] = Counter()
        newest: dict[str, Message] = {}  # by topic
        for message in self._reader.messages():
            counts[message.source] += 1
            newest[message.source.topic] = message
        for source in counts:
            if not source.is_ros1:
                raise WrongEncoding(source)
        self._names = [self._prefix + topic for topic in newest]
        self._check()
        for topic, message in newest.items():
            self._out[topic] = _publisher(message.source, self._prefix + topic)
            self._kinds[topic] = _kind(message.source)
            if topic == URDF_TOPIC:
                words = message.data[4:].decode("utf-8", "replace")
                rospy.set_param(self._prefix + URDF_TOPIC, words)
        self._say_left_out(counts)

    def _say_left_out(self, counts: Mapping[MessageSource, int]) -> None:
        left_out: Counter[str] = Counter()
        for source, count in counts.items():
            if _kind(source) != self._kinds[source.topic]:
                left_out[source.topic] += count
        for topic, count in left_out.items():
            print(f"{count} messages of {topic} of another type are not played", flush=True)

    def _check(self) -> None:
        if self._prefix or time.monotonic() - self._checked < CHECK_PERIOD:
            return
        self._checked = time.monotonic()
        if live := self._live(self._names):
            raise LiveSystem(live)

    def play(self) -> None:
        """Publish all, each message when it is due; ends early where ROS shuts down.

        Where the recorder's clock was set, the pace begins anew.

        Raises:
            LiveSystem: A running system has one of the topics.
        """
        begin, before = (0, 0.0), 0
        for message in self._reader.messages():
            if before == 0 or self._says_step(before, message.log_time):
                begin = message.log_time, time.monotonic()
            before = message.log_time
            due = begin[1] + (message.log_time - begin[0]) * 1e-9 / self._rate
            while (left := due - time.monotonic()) > 0.0 and not rospy.is_shutdown():
                time.sleep(min(left, LONGEST_SLEEP))
                self._check()
            if rospy.is_shutdown():
                return
            self._check()
            self._publish(message)

    def _says_step(self, before: int, now: int) -> bool:
        """Whether time jumps between two messages; only ours are in its order, and without gaps."""
        words = _clock_step(before, now)
        if not words or not self._reader.condition.is_numbered:
            return False
        print(f"{words}; played on at once", flush=True)
        return True

    def _publish(self, message: Message) -> None:
        topic = message.source.topic
        publisher = self._out.get(topic)
        if publisher is not None and self._kinds[topic] == _kind(message.source):
            publisher.publish(publisher.data_class(self._bytes_of(message)))
            self.count += 1

    def _bytes_of(self, message: Message) -> bytes:
        """As recorded; static frames with those of all nodes before, for viewers that come later.

        A recorded node kept its own last message for them, and the player keeps one for all.
        """
        if message.source.topic == STATIC_TOPIC:
            with suppress(Undecodable, MissingField):  # then as it is
                return self._frames.merged(message)
        return message.data


class NoMaster(SessionLogError):
    """Nobody answers where the ROS master should be."""


class LiveSystem(SessionLogError):
    """A running system has a topic that would be played."""

    def __init__(self, live: list[str]) -> None:
        super().__init__(
            f"in use by a running system: {', '.join(live[:3])}; play on a roscore of its own, or "
            "without --recorded-names"
        )


def _clock_step(before: int, now: int) -> str:
    """Names a jump between two log times [ns]; empty: there is none."""
    if now < before - CLOCK_STEP:
        return str(ClockStep(before, now))
    if now <= before + LONGEST_SILENCE:
        return ""
    at = datetime.fromtimestamp(before * 1e-9).astimezone()
    seconds = (now - before) * 1e-9
    words = f"the clock was set forward by {seconds:.1f} s at {at:%Y-%m-%d %H:%M:%S %Z}"
    return f"{words}, or nothing was recorded meanwhile"


def _kind(source: MessageSource) -> tuple[str, str]:
    """What tells the types of messages apart."""
    return source.datatype, source.md5sum


def _publisher(source: MessageSource, name: str) -> rospy.Publisher:
    facts = {
        "_type": source.datatype,
        "_md5sum": source.md5sum,
        "_full_text": source.definition,
        "_has_header": False,  # the recorded one stays as it is
    }
    kind = type("Recorded", (RawMessage,), facts)
    latch = source.is_latched or source.topic in (URDF_TOPIC, STATIC_TOPIC)
    return rospy.Publisher(name, kind, queue_size=1000, latch=latch)


def check_master() -> None:
    """Ask for the master, for which rospy would wait without a word.

    Raises:
        NoMaster: There is none, or the variable names no address.
    """
    if words := master_problem():
        raise NoMaster(words)


def live_nodes(topics: Collection[str]) -> list[str]:
    """Nodes other than this one and viewers that publish or hear one of the topics.

    Raises:
        NoMaster: It does not answer.
    """
    try:
        state: Any = ask_master("getSystemState")
    except FAILURES as error:
        raise NoMaster(f"the ROS master does not answer: {error}") from error
    publishers, subscribers, _ = state
    found = []
    for topic, nodes in (*publishers, *subscribers):
        if topic in topics and topic not in ("/rosout", "/rosout_agg"):
            others = (n for n in nodes if n != rospy.get_name() and not n.startswith(VIEWERS))
            found += [f"{topic} by {node}" for node in others]
    return sorted(set(found))


def main() -> None:
    """Play the recording that is named on the command line."""
    parser = argparse.ArgumentParser(prog="play", description=__doc__)
    parser.add_argument("session", help="folder of the session, or its MCAP file")
    parser.add_argument("--rate", type=float, default=1.0, help="recorded over real time")
    parser.add_argument(
        "--recorded-names",
        action="store_true",
        help=f"publish under the recorded names instead of below {PREFIX}",
    )
    options = parser.parse_args(rospy.myargv(sys.argv)[1:])
    if not 0.0 < options.rate <= 100.0:
        parser.error(f"--rate is {options.rate:g}, allowed: above 0, up to 100")
    try:
        reader = SessionReader(options.session)
        check_master()
        rospy.init_node("player", anonymous=True)
        prefix = "" if options.recorded_names else PREFIX
        player = RecordingPlayer(reader, options.rate, prefix, live_nodes)
        player.prepare()  # reads all of it
        for trouble in reader.condition.troubles:
            print(trouble, flush=True)
        time.sleep(CONNECT_TIME)
        player.play()
    except SessionLogError as error:
        sys.exit(str(error))
    except OSError as error:
        sys.exit(f"{error.filename or 'the system'}: {error.strerror or error}")
    print(f"{player.count} messages played")
