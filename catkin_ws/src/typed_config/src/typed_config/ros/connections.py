# SPDX-License-Identifier: BSD-3-Clause
"""Which publishers a subscriber is connected to at this moment, by the names that they claim."""

from __future__ import annotations

import rospy


def open_callers(link: rospy.Subscriber) -> set[str]:
    """Names of the nodes from which a connection is open; a process that ends closes it at once."""
    connections = list(link.impl.connections) if link.impl is not None else []
    return {c.callerid_pub for c in connections if not c.done and c.socket is not None}


def is_heard(link: rospy.Subscriber, name: str) -> bool:
    """Whether a connection from a node is open."""
    return name in open_callers(link)
