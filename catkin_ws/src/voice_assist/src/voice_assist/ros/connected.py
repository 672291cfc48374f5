# SPDX-License-Identifier: BSD-3-Clause
"""Whether anybody publishes what is subscribed to."""

from __future__ import annotations

import rospy


def is_connected(topic: rospy.Subscriber) -> bool:
    """Whether a publisher is there; the connection to a killed one stays, without its socket."""
    return any(connection.socket is not None for connection in topic.impl.connections)
