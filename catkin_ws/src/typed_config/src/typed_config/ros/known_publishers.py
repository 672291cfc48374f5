# SPDX-License-Identifier: BSD-3-Clause
"""Subscribers that believe the nodes they know; all others are named, and nothing else.

A name in ROS 1 is a claim. So the master is asked where the node of that name is. A message counts
only where it came from there. Nobody checks what nodes report to the master. This guards against a
forgotten script, a bag being played or a second system, and against no attacker.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any, Final

import genpy
import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from typed_config.node_names import caller_name, is_allowed
from typed_config.ros.system_names import of_this_system
from typed_config.ros.xmlrpc import FAILURES, ask

MAX_STRANGERS: Final = 64  # that are named at once
CODE: Final = "stranger"  # `reason_code` of the status
ASK_AGAIN: Final = 0.5  # [s] before a master that did not answer, or knew nothing, is asked again
DIAGNOSTICS_PERIOD: Final = 1.0  # [s]
SHARED: Final = ("/diagnostics", "/tf", "/tf_static")  # others publish there rightly: not named


class NodeAddresses:
    """Where nodes are, as the master says."""

    def __init__(self) -> None:
        self._uris: dict[str, str] = {}

    def look_up(self, name: str, is_wanted: Callable[[], bool]) -> None:
        """Ask the master for a node until it answers, or the answer is wanted no more."""
        while is_wanted() and not rospy.is_shutdown():
            try:
                uri = ask(rosgraph.get_master_uri(), "lookupNode", rospy.get_name(), name)
            except FAILURES:
                time.sleep(ASK_AGAIN)
            else:
                self._uris[name] = str(uri)
                return

    def of(self, name: str) -> str | None:
        """URI at which the master said the node is; None: it was not asked."""
        return self._uris.get(name)


class Link:
    """One subscription, and which of its connections are believed.

    Args:
        patterns: Names that are believed; empty: all.
        callback: Takes the messages that are.
        addresses: Where nodes are; shared by all links of a node.
    """

    def __init__(
        self,
        patterns: tuple[str, ...],
        callback: Callable[[Any], None],
        addresses: NodeAddresses,
    ) -> None:
        self._patterns, self._callback, self._addresses = patterns, callback, addresses
        self._ends: dict[int, tuple[object, str]] = {}  # header and URI of each connection
        self.subscriber: rospy.Subscriber | None = None

    def take(self, message: genpy.Message) -> None:
        """Hand a message on where its publisher is believed; in the thread of its connection."""
        header = getattr(message, "_connection_header", None) or {}
        is_known = is_allowed(caller_name(header.get("callerid")), self._patterns)
        if is_known and self.has_true_name(message):
            self._callback(message)

    def has_true_name(self, message: genpy.Message) -> bool:
        """Whether a message comes from where the master says that its publisher is."""
        header = getattr(message, "_connection_header", None) or {}
        name = caller_name(header.get("callerid"))
        return self._end(header, name) == self._addresses.of(name)

    def strangers(self) -> list[tuple[str, str]]:
        """Topic, and name with what is wrong about it, of all connections not believed."""
        if self.subscriber is None:
            return []
        topic, found = self.subscriber.resolved_name, list[tuple[str, str]]()
        if topic in SHARED:
            return []
        for connection in self._open():
            name = caller_name(connection.callerid_pub)
            known = self._addresses.of(name)
            if not is_allowed(name, self._patterns):
                found.append((topic, name))
            elif known is not None and connection.endpoint_id != known:
                found.append((topic, f"{name} ({connection.endpoint_id} has not that name)"))
        return found

    def _end(self, header: dict[str, str], name: str) -> str:
        """URI of the node that a header came from; a new one is looked up, which may wait."""
        known = self._ends.get(id(header))
        if known is None or known[0] is not header:
            while self.subscriber is None:  # it is just being made
                time.sleep(0.001)
            ends = {id(c.header): (c.header, c.endpoint_id) for c in self._open()}
            known = ends.get(id(header))
            self._ends = {i: end for i, end in ends.items() if i in self._ends or end is known}
            self._addresses.look_up(name, lambda: any(c.header is header for c in self._open()))
        return known[1] if known is not None else ""

    def _open(self) -> list[Any]:
        """Connections whose publisher has said who it is."""
        impl = self.subscriber.impl if self.subscriber is not None else None
        connections = list(impl.connections) if impl is not None else []
        return [c for c in connections if c.header and not c.done]


class KnownPublishers:
    """Makes subscribers, and knows who else publishes on their topics."""

    def __init__(self) -> None:
        self._links: list[Link] = []
        self._open: list[str] = []  # topics on which anybody is believed
        self._addresses = NodeAddresses()
        self._warned: set[tuple[str, str]] = set()
        self._diagnostics: rospy.Publisher | None = None
        self._due = 0.0  # [s] when `publish_status` publishes next

    def subscribe(
        self,
        topic: str,
        kind: type[genpy.Message],
        callback: Callable[[Any], None],
        names: Sequence[str],
        **options: Any,
    ) -> rospy.Subscriber:
        """Subscribe to a topic.

        Args:
            topic: Its name.
            kind: Of its messages.
            callback: Takes messages of the nodes named.
            names: Of these nodes as settings have them, where a * may stand at the end; empty: all
                are taken.
            options: As of rospy.Subscriber.
        """
        patterns = tuple(map(of_this_system, names))
        link = Link(patterns, callback, self._addresses)
        taken = link.take if patterns else callback
        link.subscriber = rospy.Subscriber(topic, kind, taken, **options)
        self._links.append(link)
        if not patterns:
            self._open.append(link.subscriber.resolved_name)
            rospy.logwarn("%s: anybody is believed; the settings name nobody", self._open[-1])
        return link.subscriber

    def watch(self) -> Link:
        """A link that takes all names, for a subscriber that somebody else makes."""
        link = Link((), lambda _: None, self._addresses)
        self._links.append(link)
        return link

    def strangers(self) -> list[str]:
        """Who is connected to a topic and not believed there: "/topic from /node"."""
        found = [stranger for link in self._links for stranger in link.strangers()]
        for topic, name in set(found) - self._warned:
            if len(self._warned) < MAX_STRANGERS:
                self._warned.add((topic, name))
                rospy.logwarn("%s publishes on %s and is not believed", name, topic)
        return sorted(f"{topic} from {name}" for topic, name in found)[:MAX_STRANGERS]

    def status(self, prefix: str, node: str) -> DiagnosticStatus:
        """What diagnostics say of them.

        Args:
            prefix: Of the status's name.
            node: That does not believe them.
        """
        found = self.strangers()
        words, level = "no strangers on its topics", DiagnosticStatus.OK
        if self._open:
            words += f"; anybody is believed on {', '.join(self._open)}"
            level = DiagnosticStatus.WARN
        if found:
            words, level = f"not believed: {', '.join(found)}", DiagnosticStatus.ERROR
        values = [KeyValue("reason_code", CODE if found else "")]
        return DiagnosticStatus(
            level=level,
            name=f"{prefix}: strangers",
            message=words,
            hardware_id=node,
            values=values,
        )

    def publish_status(self) -> None:
        """Publish the status of a node that has no other diagnostics; once a second at most."""
        now = time.monotonic()
        if now < self._due:
            return
        self._due = now + DIAGNOSTICS_PERIOD
        if self._diagnostics is None:
            self._diagnostics = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=2)
        name = rospy.get_name().rpartition("/")[2]
        array = DiagnosticArray(status=[self.status(name, name)])
        array.header.stamp = rospy.Time.now()
        self._diagnostics.publish(array)
