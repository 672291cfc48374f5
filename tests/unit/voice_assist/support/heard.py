# SPDX-License-Identifier: BSD-3-Clause
"""Topics that a part of a node hears, without ROS."""


class Heard:
    """Stands for ROS: by whom each topic is heard, and its callback."""

    def __init__(self):
        self.by, self.callbacks = {}, {}

    def hear(self, by, topic, kind, callback, **options):
        assert topic not in self.by, "it is heard once"
        self.by[topic], self.callbacks[topic] = by, callback
