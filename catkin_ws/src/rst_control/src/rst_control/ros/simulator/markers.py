# SPDX-License-Identifier: BSD-3-Clause
"""What the simulator shows of the tissue in rviz or Foxglove, on `robot/tissue_markers`."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import suppress

import numpy as np
import rospy

from rst_control.config import TissueConfig
from rst_control.ros.common.marker_topic import MarkerTopic
from rst_control.simulation.rendering.state import SceneState
from rst_control.simulation.rendering.tissue_shapes import TissueShapes

PERIOD = 0.2  # [s] between two checks; a message has 30 kB
REST_PERIOD = 2.0  # [s] between two messages while nothing moves
LIFETIME = 5.0  # [s] after which a viewer forgets a simulator that fell silent
SAME = 5e-5  # [m] a sheet moved by less is not sent again


class SimulatorMarkers:
    """Publishes the tissue from a thread of its own, until it is closed.

    Args:
        config: The sheet.
        copy_state: Takes a copy of the present state, from any thread.
    """

    def __init__(self, config: TissueConfig, copy_state: Callable[[], SceneState]) -> None:
        self._make, self._copy_state = TissueShapes(config), copy_state
        self._topic = MarkerTopic("robot/tissue_markers", LIFETIME)
        self._shown: SceneState | None = None
        self._sent = 0.0
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="markers", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the thread; a message under way is not waited for."""
        self._ended.set()

    def _run(self) -> None:
        while not self._ended.wait(PERIOD):
            with suppress(TimeoutError, rospy.ROSException):  # the simulation or the node is ending
                self._update()

    def _update(self) -> None:
        state, now = self._copy_state(), time.monotonic()
        if not self._has_changed(state) and now - self._sent < REST_PERIOD:
            return
        self._shown, self._sent = state, now
        self._topic.publish(self._make(state.nodes, state.held), rospy.Time.now())

    def _has_changed(self, state: SceneState) -> bool:
        shown = self._shown
        if shown is None or shown.held != state.held:
            return True
        return bool(np.abs(shown.nodes - state.nodes).max() > SAME)
