# SPDX-License-Identifier: BSD-3-Clause
"""Which connections of publishers, subscribers and services are open, and how they are kept."""

from __future__ import annotations

import socket
import threading
import time
from typing import Final

import rosgraph
import rospy
from rospy.impl.registration import (
    Registration,
    get_registration_listeners,
    get_service_manager,
    get_topic_manager,
)

from typed_config.node_names import caller_name
from typed_config.ros.xmlrpc import FAILURES, ask

LOOK: Final = 1.0  # [s] between looks whether the master knows this node
UNKNOWN_FOR: Final = 10.0  # [s] for `master_failover`, or a new node of this name, to come first


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
    alive = [c for c in connections if not c.done and c.socket is not None]
    return {caller_name(c.endpoint_id) for c in alive if not is_closed(c.socket)}


def open_callers(link: rospy.Subscriber) -> set[str]:
    """Names of the nodes, as they claim them, from which a subscriber has an open connection.

    A process that ends closes it at once.
    """
    connections = list(link.impl.connections) if link.impl is not None else []
    return {c.callerid_pub for c in connections if not c.done and c.socket is not None}


def is_heard(link: rospy.Subscriber, name: str) -> bool:
    """Whether a connection from a node is open."""
    return name in open_callers(link)


def stay_registered() -> None:
    """Register this node with a master that goes on without knowing it; in a thread of its own.

    rospy registers once. Of a system that is launched anew beside this node, the master is another.
    Service calls reach it, as each is looked up, and topics do not.
    """
    threading.Thread(target=_stay_registered, name="registration", daemon=True).start()


def _stay_registered() -> None:
    known_at = time.monotonic()
    while not rospy.is_shutdown():
        if not _is_unknown():
            known_at = time.monotonic()
        elif time.monotonic() - known_at > UNKNOWN_FOR:
            rospy.logerr("the ROS master does not know this node, which is registered again")
            _register()
        rospy.rostime.wallsleep(LOOK)


def _is_unknown() -> bool:
    """Whether the master answers that no node has this name.

    Where a new node has it, this one leaves it alone: each would end the other.
    """
    name = rospy.get_name()
    try:
        ask(rosgraph.get_master_uri(), "lookupNode", name, name)
    except ValueError:  # of an answer that it failed
        return True
    except FAILURES:
        return False
    return False


def _register() -> None:
    """All topics and services, as rospy does when each is made."""
    topics, register = get_topic_manager(), get_registration_listeners().notify_added
    for name, kind in topics.get_publications():
        register(name, kind, Registration.PUB)
    for name, kind in topics.get_subscriptions():
        register(name, kind, Registration.SUB)
    for name, uri in get_service_manager().get_services():
        register(name, uri, Registration.SRV)
