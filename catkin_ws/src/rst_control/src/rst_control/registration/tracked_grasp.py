# SPDX-License-Identifier: BSD-3-Clause
"""Takes the grasp point from a tracker by itself: steady, near, at rest and with empty jaws."""

from __future__ import annotations

from concurrent.futures import Future

import numpy as np

from rst_control.config.tracking import TrackingConfig
from rst_control.execution.orders import Reply
from rst_control.registration.grasp_point import GraspPointRegistrar
from rst_control.registration.registrar import ready
from rst_control.registration.tracked_place import Report, SteadyPlace
from rst_control.registration.trocar_context import ActiveTrocarContext
from rst_control.types import Cause, Vector


class TrackedGrasp:
    """Follows what a tracker reports; `step` sets what may be set.

    Args:
        config: What is believed, and whether it is taken.
        present: The active grasp point.
        registrar: Sets another.
    """

    def __init__(
        self,
        config: TrackingConfig,
        present: ActiveTrocarContext,
        registrar: GraspPointRegistrar,
    ) -> None:
        self._config, self._present, self._registrar = config.grasp_point, present, registrar
        home = np.array(present.current.config.scene.grasp_point)
        self._place = SteadyPlace(config.grasp_point, config.age, home)
        self._tried: Vector | None = None  # [m] the last that was asked for, set or refused

    def update(self, report: Report) -> None:
        """Take in a report."""
        self._place.update(report)

    def objection(self, now: float) -> Cause | None:
        """Why the tracked point is not taken now; None: it is, or would be."""
        found = self._place.taken(now)
        return found if isinstance(found, Cause) else None

    def step(self, now: float, tracker: str) -> Future[Reply] | None:
        """Ask for the tracked point where it is another than the active one; None: nothing to do.

        Args:
            now: Time [s], steady clock.
            tracker: Name of the node that reported it.
        """
        found = self._place.taken(now) if self._config.is_taken else None
        if not isinstance(found, Report):
            return None
        if self._is_near(found.place, np.array(self._present.current.config.scene.grasp_point)):
            return None
        if self._tried is not None and self._is_near(found.place, self._tried):
            return None  # it was refused
        if isinstance(ready(self._present.current, self._registrar.view()), Cause):
            return None
        self._tried = found.place
        return self._registrar.ask((*found.place.tolist(), *found.pull), tracker)

    def _is_near(self, place: Vector, other: Vector) -> bool:
        return float(np.linalg.norm(place - other)) < self._config.min_change
