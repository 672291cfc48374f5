# SPDX-License-Identifier: BSD-3-Clause
"""What the controller shows in rviz or Foxglove, on `rst_control/markers`."""

from __future__ import annotations

import time
from collections.abc import Callable

from rst_control.config import MotionConfig
from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.registration.trocar_context import ActiveTrocarContext
from rst_control.ros.common.marker_topic import MarkerTopic
from rst_control.ros.common.wall_clock import RosClock
from rst_control.visualization.controller_shapes import ControllerShapes

PERIOD = 0.1  # [s] between two looks
REST_PERIOD = 0.5  # [s] between two messages while nothing moves
LIFETIME = 2.0  # [s] after which a viewer forgets a controller that fell silent


class ControllerMarkers:
    """Looks at the controller's state from a thread of its own.

    Args:
        config: Scene and limits of tension.
        context: Knows the robot and the active trocar.
        look: Gives the controller's state; from any thread.
        clock: Gives its stamp.
    """

    def __init__(
        self,
        config: MotionConfig,
        context: ActiveTrocarContext,
        look: Callable[[], ControllerSnapshot],
        clock: RosClock,
    ) -> None:
        self._make = ControllerShapes(context.current.model, config)
        self._context, self._look, self._clock = context, look, clock
        self._topic = MarkerTopic("rst_control/markers", LIFETIME)
        self._sent, self._serial = -REST_PERIOD, -1

    def step(self) -> None:
        """Wait for a period, then publish where it is worth it."""
        time.sleep(PERIOD)
        view, now = self._look(), time.monotonic()
        if view.is_moving or view.serial != self._serial or now - self._sent >= REST_PERIOD:
            self._sent, self._serial = now, view.serial
            shapes = self._make(view, self._context.current.config.scene)
            self._topic.publish(shapes, self._clock.stamp(view.stamp))
