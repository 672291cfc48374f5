# SPDX-License-Identifier: BSD-3-Clause
"""A pull with a tension that is only roughly known: slowly, until it is reached.

The control of `tension.py` finds the tissue's stiffness from small changes of a sensor. An estimate
from joint torques has errors as large as these changes. So here the tension only says when to stop.
"""

from __future__ import annotations

from dataclasses import replace

from rst_control.config import TensionConfig
from rst_control.execution.phase_execution import TowardsTension, tension_invalid
from rst_control.planning.plan import Phase
from rst_control.tension.delay_bound import DelayBound
from rst_control.trajectory.motion_profile import MotionBounds, MotionProfile
from rst_control.trajectory.path import Path
from rst_control.types import Measurement, PathState, Vector


class GuardedPull(TowardsTension):
    """Goes along a path until the tension is that of the phase, or to the furthest s.

    It is as slow as lets the stiffest tissue expected rise by no more than the tolerance within
    the delay of the tension, and stops earlier by what the tension rose by within the last delay.

    Args:
        phase: With a path and a tension.
        path: That of the phase.
        state: Where on the path, and how fast, it starts.
        opening: Of the jaws, which stays [rad].
        bounds: Of the motion along the path.
        brakes: Of a stop.
        config: Of the tension.
    """

    def __init__(
        self,
        phase: Phase,
        path: Path,
        state: PathState,
        opening: float,
        bounds: MotionBounds,
        brakes: MotionBounds,
        config: TensionConfig,
    ) -> None:
        super().__init__(phase, path, state, opening, brakes)
        rise = max(config.delay, 1e-3) * config.blind_stiffness  # [N s/m]
        speed = min(bounds.speed, config.tolerance / rise)
        self._profile = MotionProfile(state, replace(bounds, speed=speed))
        self._delay_bound = DelayBound(config.delay)

    @property
    def state(self) -> PathState:
        """Where on the path it is."""
        return (self._brake or self._profile).state

    def step(self, dt: float, measured: Measurement) -> tuple[Vector, Vector]:
        """Move on by a time [s]; see `PhaseExecution`."""
        self._delay_bound.update(measured.stamp, measured.tension)
        if self._feel(measured.tension):
            self._profile.go_to(self._furthest if self.is_pulling else 0.0)
        profile = self._brake or self._profile
        state = profile.step(dt)
        self.is_done = profile.is_done
        if self._brake is None:
            self.failure = tension_invalid(measured)
            if self.failure or self._is_reached:
                self._brake_from(state)
        return self._joints(state)

    @property
    def _is_reached(self) -> bool:
        if self.is_pulling:
            return self._now + self._delay_bound.ahead >= self._goal
        return self._now <= self._goal
