# SPDX-License-Identifier: BSD-3-Clause
"""Registers a node again with a master that goes on without knowing it."""

from __future__ import annotations

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

from typed_config.ros.xmlrpc import FAILURES, ask

LOOK: Final = 1.0  # [s] between looks whether the master knows this node
UNKNOWN_FOR: Final = 10.0  # [s] for `master_failover`, or a new node of this name, to come first


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
