# SPDX-License-Identifier: BSD-3-Clause
"""A click into the endoscope's picture means the point of tissue that is drawn there."""

from copy import deepcopy
from dataclasses import replace

import numpy as np
import pybullet
import pytest

from rst_control.config import load_simulation_config
from rst_control.ros.simulator.pictures import endoscope_messages
from rst_control.simulation.camera_geometry import camera_matrix, camera_pose
from rst_control.tissue.sheet import rest_points, sheet_normal
from tests.unit.voice_assist.display.support.theatre import Clock
from tests.unit.voice_assist.support.heard import Heard
from typed_config import load_file
from voice_assist.config.display import FILE, DisplayConfig
from voice_assist.display.picking import KEPT, NotOnTissueError, Sheet, StampedHistory
from voice_assist.ros.display.endoscope import Endoscope, camera_of

CONFIG = load_simulation_config()
NODES = rest_points(CONFIG.scene.tissue)
SHEET = Sheet(NODES, sheet_normal(CONFIG.scene.tissue))


def camera():
    return camera_of(*endoscope_messages(CONFIG))


def drawn_at(point):
    """Where PyBullet draws a point: shares of the whole picture."""
    endoscope, left = CONFIG.simulator.endoscope, CONFIG.simulator.overview.size[0]
    width, height = endoscope.size
    view = pybullet.computeViewMatrixFromYawPitchRoll(
        endoscope.target,
        endoscope.distance,
        np.degrees(endoscope.yaw),
        np.degrees(endoscope.pitch),
        0.0,
        2,
    )
    lens = pybullet.computeProjectionMatrixFOV(
        np.degrees(endoscope.field_of_view), width / height, 0.01, 1.0
    )
    matrix = np.reshape(lens, (4, 4)).T @ np.reshape(view, (4, 4)).T
    x, y, _, w = matrix @ [*point, 1.0]
    u, v = left + 0.5 * width * (1.0 + x / w), 0.5 * height * (1.0 - y / w)
    return u / (left + width), v / height


def seen_nodes():
    left = camera().region[0] / camera().size[0]
    places = [(node, drawn_at(node)) for node in NODES]
    return [(node, at) for node, at in places if left <= at[0] < 1.0 and 0.0 <= at[1] < 1.0]


def test_every_node_is_found_where_it_is_drawn():
    seen = seen_nodes()
    assert len(seen) > 50
    for node, (x, y) in seen:
        np.testing.assert_allclose(SHEET.nearest(camera(), x, y), node, atol=1e-9)


def test_the_pinhole_agrees_with_what_is_drawn():
    endoscope, left = CONFIG.simulator.endoscope, CONFIG.simulator.overview.size[0]
    T, K = camera_pose(endoscope), camera_matrix(endoscope, left)
    for node in NODES[::7]:
        seen = K @ (np.linalg.inv(T) @ [*node, 1.0])[:3]
        pixels = np.array(drawn_at(node)) * camera().size
        np.testing.assert_allclose(seen[:2] / seen[2], pixels, atol=1e-3)


@pytest.mark.parametrize("x", [0.0, 0.2, 0.499])
def test_the_overview_is_no_endoscope(x):
    with pytest.raises(NotOnTissueError, match="outside the endoscope"):
        SHEET.nearest(camera(), x, 0.5)


@pytest.mark.parametrize(("x", "y"), [(0.51, 0.01), (0.99, 0.01)])
def test_a_click_beside_the_tissue_means_nothing(x, y):
    with pytest.raises(NotOnTissueError, match=r"nearest is \d+\.\d mm away, allowed: 6 mm"):
        SHEET.nearest(camera(), x, y)


def test_tissue_behind_the_camera_or_on_edge_is_not_hit():
    here = camera()
    back = here.pose.copy()
    back[:3, 0] *= -1.0
    back[:3, 2] *= -1.0
    with pytest.raises(NotOnTissueError, match="behind the endoscope"):
        SHEET.nearest(replace(here, pose=back), 0.75, 0.5)
    edge = replace(SHEET, normal=np.cross(here.pose[:3, 2], SHEET.normal))
    with pytest.raises(NotOnTissueError, match=r"edge there, at 0\.\d°, allowed: from 2\.9° on"):
        edge.nearest(here, 0.75, 0.5)


@pytest.fixture
def history():
    """What was said of the camera; its clock shows what is set."""
    clock = Clock()
    return StampedHistory(clock), clock


def test_a_camera_that_never_moves_is_said_once_for_all_pictures(history):
    said, clock = history
    with pytest.raises(NotOnTissueError, match="nobody says where"):
        said.at(5.0)
    said.add(0.0, "here")
    clock.now += 100.0 * KEPT
    assert [said.at(stamp) for stamp in (0.0, 5.0, 1e9)] == ["here"] * 3


def test_the_last_that_was_said_before_a_picture_counts(history):
    said, clock = history
    for stamp in range(10, 13):
        said.add(stamp, f"at {stamp}")
        clock.now += 1.0
    found = [said.at(stamp) for stamp in (10.0, 11.9, 12.0, 99.0)]
    assert found == ["at 10", "at 11", "at 12", "at 12"]
    with pytest.raises(NotOnTissueError, match="no longer known: click into a newer"):
        said.at(9.9)
    with pytest.raises(NotOnTissueError, match="has no time stamp"):
        said.at(0.0)


def test_what_was_said_long_ago_is_kept_no_more_but_for_what_still_holds(history):
    said, clock = history
    said.add(10.0, "old")
    clock.now += KEPT + 1.0
    said.add(20.0, "new")
    assert said.at(19.0) == "old"  # it held until just now
    clock.now += KEPT + 1.0
    said.add(30.0, "newest")
    assert said.at(29.0) == "new"
    with pytest.raises(NotOnTissueError, match="no longer known"):
        said.at(19.0)


def test_a_click_means_what_the_camera_saw_when_the_picture_was_taken(monkeypatch):
    config, heard = load_file(DisplayConfig, FILE).picture, Heard()
    monkeypatch.setattr("voice_assist.ros.display.endoscope._sheet", lambda: SHEET)
    endoscope = Endoscope(config, heard)
    info, pose = endoscope_messages(CONFIG)
    heard.callbacks[config.camera_info](info)
    node, (x, y) = seen_nodes()[40]
    for stamp, moved in ((10, 0.0), (20, 0.02)):
        pose = deepcopy(pose)
        pose.header.stamp.secs = stamp
        pose.pose.position.x += moved
        heard.callbacks[config.camera_pose](pose)
    np.testing.assert_allclose(endoscope.point(x, y, 15.0), node, atol=1e-9)
    assert np.linalg.norm(np.subtract(endoscope.point(x, y, 25.0), node)) > 0.01
    with pytest.raises(NotOnTissueError, match="no longer known"):
        endoscope.point(x, y, 5.0)


def spoiled(change):
    info, pose = endoscope_messages(CONFIG)
    change(info, pose)
    return info, pose


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda info, pose: setattr(pose.header, "frame_id", "world"), "not 'base_link'"),
        (lambda info, pose: info.D.__setitem__(0, 0.1), "distorted"),
        (lambda info, pose: setattr(pose.pose.position, "x", float("nan")), "x is nan"),
        (
            lambda info, pose: setattr(pose.pose.orientation, "w", 3.0),
            "quaternion is 3.* long, allowed: 1",
        ),
        (lambda info, pose: setattr(info, "K", [0.0] * 9), r"K\[0\] is 0, allowed: above 0"),
        (
            lambda info, pose: setattr(info, "K", [1.0, *[0.0] * 8]),
            "determinant of K is 0, allowed",
        ),
        (lambda info, pose: setattr(info, "width", 0), r"picture has 0 x \d+ pixels"),
    ],
)
def test_a_camera_that_is_not_given_as_it_must_be_is_refused(change, words):
    with pytest.raises(NotOnTissueError, match=words):
        camera_of(*spoiled(change))
