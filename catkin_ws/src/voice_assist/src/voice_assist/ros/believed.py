# SPDX-License-Identifier: BSD-3-Clause
"""The believed publishers of a node of this package, as its parameters name them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import genpy
import rospy

from typed_config.node_names import is_allowed
from typed_config.ros.known_publishers import KnownPublishers
from typed_config.ros.system_names import of_this_system
from voice_assist.config.believed import believed_config


class Believed(KnownPublishers):
    """`KnownPublishers` by what the nodes publish, as believed.yaml calls it.

    Raises:
        typed_config.ConfigError: `~believed` is not as it must be.
    """

    def __init__(self) -> None:
        super().__init__()
        self._config = believed_config(rospy.get_param("~believed", None))

    def hear(
        self,
        by: str,
        topic: str,
        kind: type[genpy.Message],
        callback: Callable[[Any], None],
        **options: Any,
    ) -> rospy.Subscriber:
        """Subscribe to a topic.

        Args:
            by: Key of believed.yaml that names who is believed.
            topic: Its name.
            kind: Of its messages.
            callback: Takes the messages that are believed.
            options: As of rospy.Subscriber.
        """
        return self.subscribe(topic, kind, callback, getattr(self._config, by), **options)

    def is_believed(self, by: str, name: str) -> bool:
        """Whether a node of that name is believed.

        Args:
            by: Key of believed.yaml that names who is.
            name: As the node gives it.
        """
        return is_allowed(name, map(of_this_system, getattr(self._config, by)))
