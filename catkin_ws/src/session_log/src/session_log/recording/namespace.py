# SPDX-License-Identifier: BSD-3-Clause
"""What belongs to the recorder's own system, where others run in other namespaces of one master."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

ROOT: Final = "/"
ELSEWHERE: Final = " of no namespace"  # behind the names of such nodes, where the system has one
# Topics that all systems of a master share.
SHARED_TOPICS: Final = frozenset({"/rosout", "/diagnostics", "/tf", "/tf_static", "/clock"})


class Namespace:
    """Names within one namespace. In a recording they are those of a system without one.

    Args:
        name: As rospy gives it: "/", or such as "/left/".
    """

    def __init__(self, name: str) -> None:
        self.name = name

    @property
    def suffix(self) -> str:
        """For the names of folders: two systems may start in the same second."""
        return self.name.rstrip("/").replace("/", "_")

    def resolved(self, name: str) -> str:
        """A topic of the settings, such as "/joint_states", as the master knows it."""
        return name if name in SHARED_TOPICS else self.name + name.removeprefix("/")

    def recorded(self, name: str) -> str:
        """A topic or node of the master as the recording has it."""
        return "/" + name.removeprefix(self.name) if name.startswith(self.name) else name

    def publisher(self, node: str) -> str:
        """Who published, as the recording names it; a node elsewhere is none of this system."""
        return self.recorded(node) if node.startswith(self.name) else node + ELSEWHERE

    def has_topic(self, name: str) -> bool:
        """Whether a topic of the master is recorded. Without a namespace all are."""
        return name.startswith(self.name) or name in SHARED_TOPICS

    def has_node(self, name: str) -> bool:
        """Whether what a node publishes on a shared topic is: one of this namespace, or of none."""
        return name.startswith(self.name) or name.rfind("/") == 0

    def parameters(self, tree: Mapping[str, Any]) -> dict[str, Any]:
        """Of the whole parameter server: those of this system, and the values of all."""
        own: Any = tree
        for part in self.name.strip("/").split("/") if self.name != ROOT else ():
            own = own.get(part, {}) if isinstance(own, Mapping) else {}
        values = {key: value for key, value in tree.items() if not isinstance(value, Mapping)}
        values.pop("robot_description", None)  # of a system without a namespace
        return {**values, **own} if isinstance(own, Mapping) else values
