# SPDX-License-Identifier: BSD-3-Clause
"""Names of the settings, such as "/controller", where a system runs in a namespace."""

from __future__ import annotations

import rospy


def of_this_system(name: str) -> str:
    """A whole name as the settings have it, below the namespace of this node: "/left/controller".

    A name that lies there already stays as it is, and so does one of settings that name nobody.
    """
    namespace = rospy.get_namespace()
    if not name or name.startswith(namespace):
        return name
    return namespace + name.removeprefix("/")
