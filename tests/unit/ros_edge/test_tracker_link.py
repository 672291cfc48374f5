# SPDX-License-Identifier: BSD-3-Clause
"""What diagnostics show of a tracked trocar that is not followed."""

import time
from types import SimpleNamespace

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PointStamped

from rst_control.config import load_motion_config
from rst_control.ros.controller.places.tracker_link import TrackerLink
from rst_control.types import Cause, Reason

CONFIG = load_motion_config()
HOME = np.array(CONFIG.scene.trocar)
UNKNOWN = Cause(Reason.UNKNOWN_FRAME, "frame camera is not known")


class Tracked:
    """A link with a fixed trocar, without ROS."""

    def __init__(self, frame=None):
        frames = SimpleNamespace(in_base=lambda *_: np.eye(4) if frame is None else frame)
        clock = SimpleNamespace(steady=lambda _: self.stamp)
        known = SimpleNamespace(subscribe=lambda *_, **__: None)
        tracking, grasp = CONFIG.controller.tracking, SimpleNamespace()
        self.link = TrackerLink(tracking, known, frames, clock, grasp, None, CONFIG.scene.trocar)
        self.stamp = 0.0

    def report(self, place, age=0.0):
        self.stamp = time.monotonic() - age
        message = PointStamped()
        message.point.x, message.point.y, message.point.z = place
        self.link._on_trocar(message)
        return self.status()

    def status(self):
        found = self.link.status()
        return found, {value.key: value.value for value in found.values}


def test_without_a_report_nothing_is_tracked():
    found, values = Tracked().status()
    assert (found.level, found.message) == (DiagnosticStatus.OK, "nothing is tracked")
    assert values == {"reason_code": ""}


def test_a_good_report_is_shown_with_its_distance_from_the_scenes():
    found, values = Tracked().report(HOME + np.array([0.002, 0.0, 0.0]))
    assert (found.level, found.message) == (DiagnosticStatus.OK, "trocar: shown only")
    assert values["trocar away from the scene's [mm]"] == "2.00"


@pytest.mark.parametrize(
    ("frame", "away", "age", "code", "words"),
    [
        (None, 0.05, 0.0, "tracker_too_far", "50.0 mm"),
        (None, 0.0, 5.0, "tracker_stale", "old"),
        (UNKNOWN, 0.0, 0.0, "unknown_frame", "frame camera is not known"),
    ],
)
def test_a_report_that_would_not_be_followed_is_shown_with_the_reason(
    frame, away, age, code, words
):
    found, values = Tracked(frame).report(HOME + np.array([away, 0.0, 0.0]), age)
    assert found.level == DiagnosticStatus.WARN and words in found.message
    assert values["reason_code"] == code
