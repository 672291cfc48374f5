# SPDX-License-Identifier: BSD-3-Clause
"""Shapes become markers that any viewer takes; tissue, trail and arrow are where they should be."""

from io import BytesIO

import numpy as np
import rospy
from visualization_msgs.msg import Marker, MarkerArray

from rst_control.config import load_simulation_config
from rst_control.ros.common.marker_topic import marker_array
from rst_control.simulation.rendering.marks import SIDES, tube
from rst_control.simulation.rendering.tissue_shapes import HELD, TissueShapes
from rst_control.simulation.rendering.trail import LONGEST, SPACING, Trail
from rst_control.simulation.tissue import rest_points, rim_nodes
from rst_control.visualization.shapes import Shape, ShapeKind

TISSUE = load_simulation_config().scene.tissue
REST = rest_points(TISSUE)
STAMP, LIFETIME = rospy.Time(12, 34), rospy.Duration(2)
ONE = {
    ShapeKind.LINE: Marker.LINE_STRIP,
    ShapeKind.BALLS: Marker.SPHERE_LIST,
    ShapeKind.ARROW: Marker.ARROW,
    ShapeKind.TRIANGLES: Marker.TRIANGLE_LIST,
    ShapeKind.LABEL: Marker.TEXT_VIEW_FACING,
}


def shape(kind, count=3):
    points = np.arange(3.0 * count).reshape(count, 3)
    return Shape(kind.value, kind, points, 0.01, (0.1, 0.2, 0.3, 0.4), text="words")


def sent(shapes, gone=()):
    """What arrives after a way through the wire."""
    buffer = BytesIO()
    marker_array(shapes, gone, STAMP, LIFETIME).serialize(buffer)
    return MarkerArray().deserialize(buffer.getvalue()).markers


def test_every_kind_has_its_marker_with_frame_stamp_lifetime_and_a_size_a_viewer_accepts():
    for kind, wanted in ONE.items():
        (marker,) = sent([shape(kind)])
        assert (marker.type, marker.action, marker.ns, marker.id) == (wanted, 0, kind.value, 0)
        assert (marker.header.frame_id, marker.header.stamp) == ("base_link", STAMP)
        assert marker.lifetime == LIFETIME and marker.pose.orientation.w == 1.0
        assert max(marker.scale.x, marker.scale.z) > 0.0 and marker.color.a > 0.0


def test_a_label_stands_at_its_point_and_all_else_is_made_of_its_points():
    (label,) = sent([shape(ShapeKind.LABEL, 1)])
    assert (label.pose.position.z, label.text, label.points) == (2.0, "words", [])
    (line,) = sent([shape(ShapeKind.LINE)])
    assert [(p.x, p.y, p.z) for p in line.points] == [(0, 1, 2), (3, 4, 5), (6, 7, 8)]
    assert line.pose.position.x == 0.0


def test_what_is_gone_is_deleted_by_its_name():
    first, second = sent([shape(ShapeKind.LINE)], gone=["tension"])
    assert (first.ns, first.id, first.action) == ("tension", 0, Marker.DELETE)
    assert second.action == Marker.ADD


def test_the_sheet_has_a_colour_at_every_corner_and_its_rim_stays_marked():
    shapes = {s.name: s for s in TissueShapes(TISSUE)(REST, -1)}
    columns, rows = TISSUE.nodes
    (sheet,) = sent([shapes["tissue"]])
    assert len(sheet.points) == len(sheet.colors) == 6 * (columns - 1) * (rows - 1)
    assert len(shapes["tissue rim"].points) == rim_nodes(TISSUE).sum()
    assert "tissue held" not in shapes


def test_a_held_node_is_marked_and_stretch_is_darker():
    pulled = REST.copy()
    held = int(np.linalg.norm(REST - TISSUE.reference_point, axis=1).argmin())
    pulled[held] += [0.0, 0.0, 0.01]
    at_rest, stretched = TissueShapes(TISSUE)(REST, -1)[0], TissueShapes(TISSUE)(pulled, held)
    np.testing.assert_array_equal(stretched[2].points, pulled[[held]])
    assert stretched[2].colour == HELD
    near = np.linalg.norm(stretched[0].points - pulled[held], axis=1) < 1e-9
    assert near.any()
    assert (stretched[0].colours[near, 1] < at_rest.colours[near, 1] - 0.05).all()


def test_the_trail_keeps_points_of_even_spacing_and_forgets_the_oldest():
    trail = Trail()
    for x in np.arange(0.0, 2.0 * LONGEST * SPACING, 0.2 * SPACING):
        trail.add(np.array([x, 0.0, 0.0]))
    steps = np.diff(trail.points[:, 0])
    assert len(trail.points) == LONGEST
    assert steps.min() >= SPACING * 0.999 and steps.max() <= 1.21 * SPACING


def test_a_tube_lies_at_its_radius_around_its_line():
    line = np.array([[0.0, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0, 0.02, 0.0]])
    vertices, normals = tube(line, np.array([0.001, 0.002, 0.001]))
    away = vertices - np.repeat(line, SIDES, axis=0)
    assert np.allclose(np.linalg.norm(away, axis=1), np.repeat([0.001, 0.002, 0.001], SIDES))
    assert np.allclose(away[:, 1], 0.0) and np.allclose(np.linalg.norm(normals, axis=1), 1.0)


def test_a_tube_whose_line_turns_back_stays_finite():
    line = np.array([[0.0, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0, 0.0, 0.0]])
    vertices, _ = tube(line, np.full(3, 0.001))
    assert np.isfinite(vertices).all()
