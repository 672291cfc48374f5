# SPDX-License-Identifier: BSD-3-Clause
"""Who publishes what is subscribed to."""

from __future__ import annotations

from typing import Any

import rospy

from typed_config.node_names import caller_name


def is_connected(topic: rospy.Subscriber) -> bool:
    """Whether a publisher is there; the connection to a killed one stays, without its socket."""
    return any(connection.socket is not None for connection in topic.impl.connections)


def publisher_of(message: Any) -> str:
    """Name of the node that a message came from."""
    header = getattr(message, "_connection_header", None) or {}
    return caller_name(header.get("callerid"))
