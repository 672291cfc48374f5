# SPDX-License-Identifier: BSD-3-Clause
"""The topics live for Foxglove, by foxglove-sdk: to be read, and nothing else.

No capability is offered, so a viewer can publish nothing, call no service and set no parameter. A
topic is subscribed while a viewer asks for it.
"""

from __future__ import annotations

import re
import sys
import threading
import time
from collections import deque
from contextlib import suppress
from queue import Empty, Queue
from typing import TYPE_CHECKING, Any

import roslib.message
import rospy
from std_msgs.msg import String

from session_log.config import FoxgloveConfig
from session_log.recording.namespace import Namespace
from session_log.ros.discovery import data_of
from session_log.types import URDF_TOPIC
from typed_config import package_file
from typed_config.priority import set_priority
from typed_config.ros.connections import open_callers
from typed_config.ros.private_settings import private_settings
from typed_config.ros.starting import starting
from typed_config.ros.xmlrpc import FAILURES, parameter, published_topics

if TYPE_CHECKING:
    import foxglove

FILE = package_file("session_log", "config/foxglove.yaml")
NICE = 10  # it only shows
SOUND = {  # types of what is said in the theatre, which is never served
    "voice_assist/AudioChunk",
    "audio_common_msgs/AudioData",
    "audio_common_msgs/AudioDataStamped",
}
INSTALL = "foxglove-sdk is missing: .venv/bin/pip install -r requirements-foxglove.txt"
AGAIN = 0.5  # [s] from a viewer's wish, or the last try, to the next try
TRIES = 5  # times that a topic without a connection is subscribed anew, or the URDF asked for
NO_TEXT = bytes(4)  # an empty std_msgs/String
IDLE = 0.2  # [s] between checks whether ROS ends


class LiveTopics:
    """Channels of Foxglove for the topics of this system.

    Args:
        config: Which topics.
        namespace: Whose they are.
    """

    def __init__(self, config: FoxgloveConfig, namespace: Namespace) -> None:
        self._namespace = namespace
        self._exclude = [re.compile(pattern) for pattern in config.exclude]
        self._channels: dict[str, foxglove.Channel] = {}  # by the topic as it is shown
        self._names: dict[str, str] = {}  # by the same, the topic of the master
        self._viewers: dict[str, int] = {}
        self._subscribers: dict[str, rospy.Subscriber] = {}
        self._latched: dict[str, dict[str, bytes]] = {}  # by topic and publisher, the latest last
        self._refused: set[str] = set()
        self._again: deque[tuple[float, str, int]] = deque()  # [s] when, topic, tries left
        self._wishes: Queue[tuple[str, int]] = Queue()  # topics, and how many viewers more

    # The two methods of a `foxglove.ServerListener`, called by the server's threads

    def on_subscribe(self, client: object, channel: Any) -> None:
        """A viewer asks for a topic."""
        self._wishes.put((channel.topic, 1))

    def on_unsubscribe(self, client: object, channel: Any) -> None:
        """A viewer needs a topic no more."""
        self._wishes.put((channel.topic, -1))

    def search(self) -> None:
        """Offer the topics that are new."""
        if URDF_TOPIC not in self._channels:
            self._add(URDF_TOPIC, "", String)
        for name, kind in published_topics():
            shown = self._namespace.recorded(name)
            is_ours = self._namespace.has_topic(name)
            if shown in self._channels or shown in self._refused or not is_ours:
                continue
            if kind == rospy.AnyMsg._type:
                continue  # nobody knows yet what it is
            message = _class_of(kind)
            is_excluded = kind in SOUND or any(one.fullmatch(shown) for one in self._exclude)
            if message is None or is_excluded:
                self._refused.add(shown)
                if message is None:
                    rospy.logwarn("%s is not served: %s is not built here", name, kind)
                continue
            self._add(shown, name, message)

    def follow(self, wait: float) -> None:
        """Subscribe to what viewers ask for now, and no longer to what they need no more.

        Args:
            wait: For the first wish [s].
        """
        with suppress(Empty):
            topic, more = self._wishes.get(timeout=wait)
            count = self._viewers[topic] = max(self._viewers.get(topic, 0) + more, 0)
            if more > 0:
                self._show(topic)
                self._again.append((time.monotonic() + AGAIN, topic, TRIES))
            elif count == 0 and topic in self._subscribers:
                self._subscribers.pop(topic).unregister()

        while self._again and self._again[0][0] <= time.monotonic():
            _, topic, tries = self._again.popleft()
            self._look_again(topic, tries)

    def _add(self, shown: str, name: str, message: type[Any]) -> None:
        import foxglove

        schema = foxglove.Schema(
            name=message._type, encoding="ros1msg", data=message._full_text.encode()
        )
        self._names[shown] = name
        self._channels[shown] = foxglove.Channel(shown, schema=schema, message_encoding="ros1")

    def _show(self, topic: str) -> None:
        if topic == URDF_TOPIC:
            self._latched.pop(topic, None)
            with suppress(*FAILURES):  # it is asked again
                urdf = parameter(rospy.resolve_name("robot_description"))
                data = str(urdf or "").encode()
                self._latched[topic] = {"": len(data).to_bytes(4, "little") + data}
        elif topic not in self._subscribers:
            self._latched.pop(topic, None)

            def receive(message: rospy.Message) -> None:
                self._receive(topic, message)

            name = self._names[topic]
            self._subscribers[topic] = rospy.Subscriber(name, rospy.AnyMsg, receive, queue_size=50)
        self._repeat(topic)

    def _look_again(self, topic: str, tries: int) -> None:
        """A while after a viewer came: what was latched once more; what did not come, anew."""
        if tries and self._viewers.get(topic) and self._has_no_answer(topic):
            if (subscriber := self._subscribers.pop(topic, None)) is not None:
                subscriber.unregister()
            self._show(topic)
            self._again.append((time.monotonic() + AGAIN, topic, tries - 1))
        self._repeat(topic)

    def _has_no_answer(self, topic: str) -> bool:
        if topic == URDF_TOPIC:
            return self._latched.get(topic, {}).get("", NO_TEXT) == NO_TEXT
        subscriber = self._subscribers.get(topic)
        return subscriber is not None and subscriber.get_num_connections() == 0

    def _repeat(self, topic: str) -> None:
        """Send latched messages anew, for a viewer that has come since; none of who has gone."""
        subscriber = self._subscribers.get(topic)
        for publisher, last in list(self._latched.get(topic, {}).items()):
            if subscriber is None or publisher in open_callers(subscriber):
                self._channels[topic].log(last)

    def _receive(self, topic: str, message: rospy.Message) -> None:
        header, data = message._connection_header, data_of(message)
        if header.get("latching") == "1":
            latched, publisher = self._latched.setdefault(topic, {}), header.get("callerid", "")
            latched.pop(publisher, None)
            latched[publisher] = data
        self._channels[topic].log(data)


def _class_of(kind: str) -> type[Any] | None:
    """Class of a type of messages; None: it is not built here, or no name of a type."""
    try:
        found: type[Any] | None = roslib.message.get_message_class(kind)
    except ValueError:
        return None
    return found


def serve(config: FoxgloveConfig) -> None:
    """Serve topics until ROS shuts down.

    Raises:
        RuntimeError: The address cannot be had.
    """
    import foxglove

    foxglove.set_log_level("ERROR")
    topics = LiveTopics(config, Namespace(rospy.get_namespace()))
    server = foxglove.start_server(
        name="voice_assist",
        host=config.address,
        port=config.port,
        capabilities=[],
        server_listener=topics,
        message_backlog_size=config.backlog,
    )
    address = f"ws://{config.address}:{server.port}"
    rospy.loginfo("topics for Foxglove: %s", address)
    rospy.set_param("~address", address)
    if config.address not in ("127.0.0.1", "localhost", "::1"):
        rospy.logwarn("everybody who reaches %s can read all topics", config.address)
    searching = threading.Thread(target=_search, args=(topics, config), daemon=True)
    searching.start()
    while not rospy.is_shutdown():
        topics.follow(IDLE)
    server.stop()


def _search(topics: LiveTopics, config: FoxgloveConfig) -> None:
    while not rospy.is_shutdown():
        try:
            topics.search()
        except Exception as error:  # top of the thread: the next search may succeed
            rospy.logwarn_throttle(10.0, "cannot look for new topics: %s", error)
        rospy.rostime.wallsleep(config.discovery_period)


def main() -> None:
    """Run the node."""
    set_priority(NICE)
    with starting("foxglove", __doc__, needs_clock=False):
        config = private_settings(FoxgloveConfig, FILE)
        try:
            import foxglove  # noqa: F401
        except ImportError:
            rospy.logfatal("no topics for Foxglove: %s", INSTALL)
            sys.exit(2)
    try:
        serve(config)
    except RuntimeError as error:
        rospy.logfatal("topics cannot be served at %s:%d: %s", config.address, config.port, error)
        sys.exit(2)
