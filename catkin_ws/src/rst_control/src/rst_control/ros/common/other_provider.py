# SPDX-License-Identifier: BSD-3-Clause
"""Whether another node offers a service that only one may offer.

ROS sends all calls to the one that registered last. So a second controller would take every "stop"
by service from the one that moves the robot, and a simulated driver the services of the real one.
"""

from __future__ import annotations

from typing import Any

import rosgraph
import rospy

from typed_config.ros.xmlrpc import FAILURES, ask, is_alive


def other_provider(service: str) -> str:
    """Another living node that offers a service of this name; empty: none does, or none is known.

    Nodes that died without a word stay registered, and do not count. One that hangs does: it may go
    on at any moment.
    """
    name, wanted = rospy.get_name(), rospy.resolve_name(service)
    master = rosgraph.get_master_uri()
    try:
        state: Any = ask(master, "getSystemState", name)
        nodes = [node for offered, nodes in state[2] if offered == wanted for node in nodes]
    except FAILURES:
        return ""
    return next((node for node in nodes if node != name and is_alive(master, node)), "")
