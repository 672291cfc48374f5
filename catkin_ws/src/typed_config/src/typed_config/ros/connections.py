# SPDX-License-Identifier: BSD-3-Clause
"""Which connections of publishers, subscribers and services are open at this moment."""

from __future__ import annotations

import socket

import rospy

from typed_config.node_names import caller_name


def is_closed(connection: socket.socket) -> bool:
    """Whether the other end closed a connection, as where its node ended; waits for nothing."""
    try:
        return bool(connection.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT) == b"")
    except BlockingIOError:  # open, and nothing to read
        return False
    except OSError:
        return True


def open_listeners(topic: rospy.Publisher) -> set[str]:
    """Names of the nodes, as they claim them, to which a publisher has an open connection.

    rospy reads from none of them. So it counts one that ended until a message cannot be written.
    """
    connections = list(topic.impl.connections) if topic.impl is not None else []
    alive = [(c.endpoint_id, c.socket) for c in connections if not c.done]  # rospy may drop it now
    return {caller_name(name) for name, link in alive if link is not None and not is_closed(link)}


def open_callers(link: rospy.Subscriber) -> set[str]:
    """Names of the nodes, as they claim them, from which a subscriber has an open connection.

    A process that ends closes it at once.
    """
    connections = list(link.impl.connections) if link.impl is not None else []
    return {c.callerid_pub for c in connections if not c.done and c.socket is not None}


def is_heard(link: rospy.Subscriber, name: str) -> bool:
    """Whether a connection from a node is open."""
    return name in open_callers(link)
