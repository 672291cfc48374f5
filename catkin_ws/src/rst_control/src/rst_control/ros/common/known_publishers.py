# SPDX-License-Identifier: BSD-3-Clause
"""Subscribers that believe the nodes they know; all others are named, and nothing else.

In ROS 1 a node's name is what the node says it is. The master ends an older node of the same name.
So this guards against a forgotten script, a bag being played or a second system; against no
attacker.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final

import genpy
import rospy
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from rst_control.admission.callers import caller_name, is_allowed
from typed_config.ros.system_names import of_this_system

MAX_STRANGERS: Final = 16  # that are named at once
CODE: Final = "stranger"  # `reason_code` of the status


class KnownPublishers:
    """Makes subscribers, and knows who else publishes on their topics."""

    def __init__(self) -> None:
        self._links: list[tuple[rospy.Subscriber, tuple[str, ...]]] = []
        self._warned: set[tuple[str, str]] = set()

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

        def take(message: genpy.Message) -> None:
            if is_allowed(publisher_of(message), patterns):
                callback(message)

        link = rospy.Subscriber(topic, kind, take if patterns else callback, **options)
        self._links.append((link, patterns))
        return link

    def strangers(self) -> list[str]:
        """Who is connected to a topic and not believed there: "/topic from /node"."""
        found = []
        for link, patterns in self._links:
            connections = list(link.impl.connections) if link.impl is not None else []
            open_ones = (c.callerid_pub for c in connections if not c.done)
            names = {caller_name(n) for n in open_ones if n}  # none while it is being made
            found += [(link.resolved_name, n) for n in names if not is_allowed(n, patterns)]
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
        words = f"not believed: {', '.join(found)}" if found else "no strangers on its topics"
        level = DiagnosticStatus.ERROR if found else DiagnosticStatus.OK
        values = [KeyValue("reason_code", CODE if found else "")]
        return DiagnosticStatus(
            level=level,
            name=f"{prefix}: strangers",
            message=words,
            hardware_id=node,
            values=values,
        )


def publisher_of(message: genpy.Message) -> str:
    """Name that the publisher of a message gave itself when it connected."""
    header = getattr(message, "_connection_header", None) or {}
    return caller_name(header.get("callerid"))
