# SPDX-License-Identifier: BSD-3-Clause
"""Frames as tf joins them: joined over their root, and never when old or apart."""

import numpy as np
import pytest

from rst_control.registration.frames import Frames, Link, pose
from rst_control.types import Cause, Reason

QUARTER = (0.0, 0.0, np.sin(np.pi / 4), np.cos(np.pi / 4))  # about z
STRAIGHT = (0.0, 0.0, 0.0, 1.0)


def frames(age=0.0, now=10.0):
    """A camera on a stand beside the robot; both hang on the room, the camera turned by 90 deg."""
    known = Frames()
    known.put("base_link", Link("room", pose((1.0, 0.0, 0.5), STRAIGHT), np.inf))
    known.put("stand", Link("room", pose((0.0, 2.0, 0.0), STRAIGHT), np.inf))
    known.put("camera", Link("stand", pose((0.0, 0.0, 1.0), QUARTER), now - age))
    return known


def test_a_point_goes_over_the_root_of_both():
    T = frames().in_base("camera", 10.0, 0.2)
    found = T @ [0.1, 0.0, 0.0, 1.0]  # 0.1 m before the camera, which looks along the room's y
    np.testing.assert_allclose(found[:3], [-1.0, 2.1, 0.5], atol=1e-12)


@pytest.mark.parametrize("name", ["", "base_link", "/base_link"])
def test_the_base_is_itself(name):
    np.testing.assert_array_equal(Frames().in_base(name, 0.0, 0.1), np.eye(4))


def test_a_slash_in_front_makes_no_difference():
    known = frames()
    np.testing.assert_array_equal(
        known.in_base("/camera", 10.0, 0.2), known.in_base("camera", 10.0, 0.2)
    )


def test_a_frame_that_nobody_publishes_is_refused_by_name():
    refused = frames().in_base("microscope", 10.0, 0.2)
    assert isinstance(refused, Cause) and refused.reason is Reason.UNKNOWN_FRAME
    assert "'microscope'" in refused.words and "does not join" in refused.words


def test_an_old_frame_is_refused_with_its_age():
    refused = frames(age=0.5).in_base("camera", 10.0, 0.2)
    assert refused.reason is Reason.TRACKER_STALE
    assert refused.words == "frame 'camera' 0.50 s old, allowed 0.20 s"


def test_a_frame_from_the_future_is_refused():
    """The clock of another host is ahead: its last transform would be taken for as long."""
    refused = frames(age=-10.0).in_base("camera", 10.0, 0.2)
    assert refused.reason is Reason.TRACKER_STALE
    assert "stamped 10.00 s ahead, allowed 0.20 s" in refused.words
    assert isinstance(frames(age=-0.21).in_base("camera", 10.0, 0.2), Cause)


def test_a_frame_that_tf_stamps_ahead_by_its_period_is_taken():
    """The static_transform_publisher of tf stamps a transform for when the next is due."""
    assert not isinstance(frames(age=-0.1).in_base("camera", 10.0, 0.2), Cause)


def test_a_circle_of_frames_is_refused():
    known = Frames()
    known.put("a", Link("b", np.eye(4), np.inf))
    known.put("b", Link("a", np.eye(4), np.inf))
    assert known.in_base("a", 0.0, 1.0).reason is Reason.UNKNOWN_FRAME


@pytest.mark.parametrize("turn", [(np.nan, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 0.0)])
def test_what_is_no_pose_raises(turn):
    with pytest.raises(ValueError, match=r"finite|norm"):
        pose((0.0, 0.0, 0.0), turn)
