# SPDX-License-Identifier: BSD-3-Clause
"""A pull with a tension that is only roughly known: slowly, until it is reached.

`TensionControl` finds the tissue's stiffness from small changes of a sensor. An estimate
from joint torques has errors as large as these changes. So here the tension only says when to stop.
"""

from __future__ import annotations

from dataclasses import replace

from rst_control.config import TensionConfig
from rst_control.execution.phase_execution import TowardsTension
from rst_control.planning.plan import Phase
from rst_control.tension.delay_bound import DelayBound
from rst_control.tension.grasp_response import GraspResponse
from rst_control.trajectory.motion_profile import MotionBounds, MotionProfile
from rst_control.trajectory.path import Path
from rst_control.types import Measurement, PathState, Vector

SAME_AIM = 1e-6  # [m]


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
        response: Of the tissue held.
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
        response: GraspResponse,
    ) -> None:
        super().__init__(phase, path, state, opening, brakes, response)
        rise = max(config.delay, 1e-3) * config.blind_stiffness  # [N s/m]
        speed = min(bounds.speed, config.tolerance / rise)
        self._profile = MotionProfile(state, replace(bounds, speed=speed))
        self._delay_bound = DelayBound(config.delay)
        self._aim = state.s

    @property
    def state(self) -> PathState:
        """Where on the path it is."""
        return (self._brake or self._profile).state

    def step(self, dt: float, measured: Measurement) -> tuple[Vector, Vector]:
        """Move on by a time [s]; see `PhaseExecution`."""
        self._delay_bound.update(measured.stamp, measured.tension)
        self._feel(measured.tension)
        end = self._furthest if self.is_pulling else 0.0
        if self._brake is None:
            self._head_for(min(end, self._room_ends(measured)), end)
        profile = self._brake or self._profile
        state = profile.step(dt)
        self.is_done = profile.is_done and (self._brake is not None or self._aim == end)
        if self._brake is None:
            self.failure = self._objection(measured)
            if self.failure or self._is_reached:
                self._brake_from(state)
        return self._joints(state)

    def _head_for(self, aim: float, end: float) -> None:
        """Go as far as the response of the tissue allows for now, or to the end."""
        if abs(aim - self._aim) > SAME_AIM or (aim == end != self._aim):
            self._aim = aim
            self._profile.go_to(aim)

    @property
    def _is_reached(self) -> bool:
        if self.is_pulling:
            return self._now + self._delay_bound.ahead >= self._goal
        return self._now <= self._goal
