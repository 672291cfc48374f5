# SPDX-License-Identifier: BSD-3-Clause
"""Shapes as visualization_msgs/MarkerArray."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import rospy
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from rst_control.types import BASE
from rst_control.visualization.shapes import Shape, ShapeKind

HEAD_WIDTH, HEAD_LENGTH = 2.2, 2.6  # of an arrow, in widths of its shaft
_KINDS = {
    ShapeKind.LINE: Marker.LINE_STRIP,
    ShapeKind.BALLS: Marker.SPHERE_LIST,
    ShapeKind.ARROW: Marker.ARROW,
    ShapeKind.TRIANGLES: Marker.TRIANGLE_LIST,
    ShapeKind.LABEL: Marker.TEXT_VIEW_FACING,
}


class MarkerTopic:
    """Publishes the shapes of a moment; what is no longer among them is deleted.

    Args:
        name: Of the topic.
        lifetime: After which a viewer drops what was not sent again [s].
    """

    def __init__(self, name: str, lifetime: float) -> None:
        self._lifetime = rospy.Duration.from_sec(lifetime)
        self._shown: frozenset[str] = frozenset()
        self._topic = rospy.Publisher(name, MarkerArray, queue_size=1, latch=True)

    def publish(self, shapes: Sequence[Shape], stamp: rospy.Time) -> None:
        """Show the shapes, and only them."""
        names = frozenset(shape.name for shape in shapes)
        gone = sorted(self._shown - names)
        self._topic.publish(marker_array(shapes, gone, stamp, self._lifetime))
        self._shown = names


def marker_array(
    shapes: Iterable[Shape], gone: Iterable[str], stamp: rospy.Time, lifetime: rospy.Duration
) -> MarkerArray:
    """Markers that show shapes, and that delete those whose names are gone."""
    markers = [_marker(name, Marker.DELETE, stamp) for name in gone]
    return MarkerArray(markers + [_shown(shape, stamp, lifetime) for shape in shapes])


def _shown(shape: Shape, stamp: rospy.Time, lifetime: rospy.Duration) -> Marker:
    marker = _marker(shape.name, Marker.ADD, stamp)
    marker.type, marker.lifetime, marker.text = _KINDS[shape.kind], lifetime, shape.text
    marker.color = ColorRGBA(*shape.colour)
    scale, size = marker.scale, shape.size
    if shape.kind is ShapeKind.LABEL:
        marker.pose.position = Point(*shape.points[0].tolist())
        scale.z = size
        return marker
    if shape.kind is ShapeKind.ARROW:
        scale.x, scale.y, scale.z = size, HEAD_WIDTH * size, HEAD_LENGTH * size
    elif shape.kind is ShapeKind.TRIANGLES:
        scale.x = scale.y = scale.z = 1.0
    elif shape.kind is ShapeKind.BALLS:
        scale.x = scale.y = scale.z = size
    else:
        scale.x = size
    marker.points = [Point(*place) for place in shape.points.tolist()]
    if shape.colours is not None:
        marker.colors = [ColorRGBA(*colour) for colour in shape.colours.tolist()]
    return marker


def _marker(name: str, action: int, stamp: rospy.Time) -> Marker:
    marker = Marker(ns=name, id=0, action=action)
    marker.header.stamp, marker.header.frame_id = stamp, BASE
    marker.pose.orientation.w = 1.0
    return marker
