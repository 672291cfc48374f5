# SPDX-License-Identifier: BSD-3-Clause
"""Warns at the start who could reach the system from elsewhere.

The controller warns for all: it is the part that moves something, and every node has the same
master. The launch files keep the other nodes on loopback.
"""

from __future__ import annotations

import rosgraph
import rospy

from rst_control.host.listening_sockets import inodes_of, listeners, warnings


def warn_of_listeners() -> None:
    """Warn, by name, of the master and of sockets of this process that other hosts can reach."""
    for words in warnings(rosgraph.get_master_uri(), listeners(), inodes_of()):
        rospy.logwarn("%s", words)
