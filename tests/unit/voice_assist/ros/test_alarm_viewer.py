# SPDX-License-Identifier: BSD-3-Clause
"""The viewer in the terminal shows what the system's own alarm node reports, and nobody else's."""

import rospy

from tests.unit.voice_assist.support.heard import Heard
from voice_assist.ros.alarms import viewer as viewer_module
from voice_assist.ros.alarms.viewer import Lines, Viewer


def test_alarms_and_diagnostics_of_strangers_are_not_shown(monkeypatch):
    heard = Heard()

    def subscribe(*_):
        raise AssertionError("anybody is believed")

    monkeypatch.setattr(viewer_module, "Believed", lambda: heard, raising=False)
    monkeypatch.setattr(rospy, "Subscriber", subscribe)
    Viewer(Lines())
    assert heard.by == {"voice_assist/alarm": "system", "/diagnostics": "system"}
