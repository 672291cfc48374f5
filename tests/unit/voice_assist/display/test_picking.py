# SPDX-License-Identifier: BSD-3-Clause
"""A click into the endoscope's picture means the point of tissue that is drawn there."""

from dataclasses import replace

import numpy as np
import pybullet
import pytest

from rst_control.config import load_simulation_config
from rst_control.ros.simulator.pictures import endoscope_messages
from rst_control.simulation.camera_geometry import camera_matrix, camera_pose
from rst_control.tissue.sheet import rest_points, sheet_normal
from voice_assist.display.picking import NotOnTissueError, Sheet
from voice_assist.ros.display.endoscope import camera_of

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
    left, _ = camera().region[0] / camera().size[0], 0
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
    with pytest.raises(NotOnTissueError, match="no tissue"):
        SHEET.nearest(camera(), x, y)


def test_tissue_behind_the_camera_or_on_edge_is_not_hit():
    here = camera()
    back = here.pose.copy()
    back[:3, 0] *= -1.0
    back[:3, 2] *= -1.0
    with pytest.raises(NotOnTissueError):
        SHEET.nearest(replace(here, pose=back), 0.75, 0.5)
    edge = replace(SHEET, normal=np.cross(here.pose[:3, 2], SHEET.normal))
    with pytest.raises(NotOnTissueError, match="edge"):
        edge.nearest(here, 0.75, 0.5)


def spoiled(change):
    info, pose = endoscope_messages(CONFIG)
    change(info, pose)
    return info, pose


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda info, pose: setattr(pose.header, "frame_id", "world"), "not 'base_link'"),
        (lambda info, pose: info.D.__setitem__(0, 0.1), "distorted"),
        (lambda info, pose: setattr(pose.pose.position, "x", float("nan")), "no usable"),
        (lambda info, pose: setattr(pose.pose.orientation, "w", 3.0), "no usable"),
        (lambda info, pose: setattr(info, "K", [0.0] * 9), "no usable"),
        (lambda info, pose: setattr(info, "width", 0), "no usable"),
    ],
)
def test_a_camera_that_is_not_given_as_it_must_be_is_refused(change, words):
    with pytest.raises(NotOnTissueError, match=words):
        camera_of(*spoiled(change))
