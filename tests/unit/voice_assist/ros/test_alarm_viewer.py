# SPDX-License-Identifier: BSD-3-Clause
"""The viewer in the terminal shows what the system's own alarm node reports, and nobody else's."""

import rospy

from voice_assist.ros.alarms import viewer as viewer_module
from voice_assist.ros.alarms.viewer import Lines, Viewer


def test_alarms_and_diagnostics_of_strangers_are_not_shown(monkeypatch):
    heard = []

    class Known:
        def hear(self, by, topic, kind, callback):
            heard.append((by, topic))

    def subscribe(*_):
        raise AssertionError("anybody is believed")

    monkeypatch.setattr(viewer_module, "Believed", Known, raising=False)
    monkeypatch.setattr(rospy, "Subscriber", subscribe)
    Viewer(Lines())
    assert heard == [("system", "voice_assist/alarm"), ("system", "/diagnostics")]
