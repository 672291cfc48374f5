# SPDX-License-Identifier: BSD-3-Clause
"""Finds topics as they appear and hands each message on as bytes."""

from __future__ import annotations

import re
import threading
from collections.abc import Iterable
from functools import partial
from io import BytesIO

import rospy

from session_log.recording.namespace import SHARED_TOPICS, Namespace
from session_log.recording.recorder import Recorder, TopicTally
from session_log.types import MessageSource
from typed_config.ros.xmlrpc import published_topics

IDENTITY = ("callerid", "type", "md5sum", "latching")  # of a connection: one source each
RECEIVE_BUFFER = 1 << 20  # [B] taken from a socket at once


class TopicSubscriber:
    """Subscribes a recorder to every topic of its system that is not excluded."""

    def __init__(self, recorder: Recorder, namespace: Namespace, exclude: Iterable[str]) -> None:
        self._recorder, self._namespace = recorder, namespace
        self._exclude = [re.compile(pattern) for pattern in exclude]
        self._subscribers: dict[str, rospy.Subscriber] = {}
        self._tallies: dict[tuple[str, ...], TopicTally] = {}
        self._is_closed = False

    def subscribe(self, name: str) -> None:
        """Record a topic of the master from now on, whether or not someone publishes it yet."""
        recorded = self._namespace.recorded(name)
        if name in self._subscribers or not self._namespace.has_topic(name):
            return
        if any(pattern.fullmatch(recorded) for pattern in self._exclude):
            return
        self._subscribers[name] = rospy.Subscriber(
            name,
            rospy.AnyMsg,
            partial(self._receive, recorded),
            queue_size=None,  # None: rospy drops nothing on its side
            buff_size=RECEIVE_BUFFER,
            tcp_nodelay=True,
        )

    def unpublished(self, topics: Iterable[str]) -> list[str]:
        """Which of some topics of the master nobody publishes yet."""
        known = {n for n, s in list(self._subscribers.items()) if s.get_num_connections() > 0}
        return [topic for topic in topics if topic not in known]

    def close(self) -> None:
        """Stop receiving, without the master, which may hang; rospy unregisters afterwards."""
        self._is_closed = True

    def _receive(self, topic: str, message: rospy.Message) -> None:
        if self._is_closed:
            return
        header = message._connection_header
        key = (topic, *(header.get(field, "") for field in IDENTITY))
        tally = self._tallies.get(key)
        if tally is None:
            publisher = header.get("callerid", "")
            if topic in SHARED_TOPICS and not self._namespace.has_node(publisher):
                return
            source = _source(topic, header, self._namespace.publisher(publisher))
            tally = self._tallies[key] = self._recorder.register(source)
        self._recorder.offer(tally, data_of(message))


def data_of(message: rospy.Message) -> bytes:
    """A message as it came: where rospy itself reads its topic, as `/clock`, it comes decoded."""
    if isinstance(message, rospy.AnyMsg):
        data: bytes = message._buff
        return data
    buffer = BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def _source(topic: str, header: dict[str, str], publisher: str) -> MessageSource:
    return MessageSource(
        topic=topic,
        datatype=header["type"],
        md5sum=header.get("md5sum", ""),
        definition=header.get("message_definition", ""),
        publisher=publisher,
        is_latched=header.get("latching", "0") == "1",
    )


class Discovery:
    """Searches the master for new topics, periodically."""

    def __init__(self, subscriber: TopicSubscriber, period: float) -> None:
        self._subscriber, self._period = subscriber, period
        self.error = ""
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._run, name="discovery", daemon=True)

    def start(self) -> None:
        """Begin to search."""
        self._thread.start()

    def stop(self) -> None:
        """Stop the search."""
        self._stopped.set()

    def _run(self) -> None:
        while not self._stopped.is_set():
            self.error = self._search()
            self._stopped.wait(self._period)

    def _search(self) -> str:
        try:
            for topic, _ in published_topics():
                self._subscriber.subscribe(topic)
        except Exception as error:  # top of the thread: the next search may succeed
            return f"cannot look for new topics: {error}"
        return ""
