# SPDX-License-Identifier: BSD-3-Clause
"""A pull with a tension that is only roughly known: slowly, until it is reached.

`TensionControl` finds the tissue's stiffness from small changes of a sensor. An estimate
from joint torques has errors as large as these changes. So here the tension only says when to stop.
"""

from __future__ import annotations

from dataclasses import replace

from rst_control.config import TensionConfig
from rst_control.execution.phase_execution import PhaseStart, TowardsTension
from rst_control.tension.delay_bound import DelayBound
from rst_control.tension.grasp_response import GraspResponse
from rst_control.trajectory.motion_profile import MotionProfile
from rst_control.types import Measurement, Vector

SAME_AIM = 1e-6  # [m]


class GuardedPull(TowardsTension):
    """Goes along a path until the tension is that of the phase, or to the furthest s.

    It is as slow as lets the stiffest tissue expected rise by no more than the tolerance within
    the delay of the tension, and stops earlier by what the tension rose by within the last delay.

    Args:
        start: How it begins; its phase has a tension.
        config: Of the tension.
        response: Of the tissue held.
    """

    def __init__(self, start: PhaseStart, config: TensionConfig, response: GraspResponse) -> None:
        rise = max(config.delay, 1e-3) * config.blind_stiffness  # [N s/m]
        speed = min(start.bounds.speed, config.tolerance / rise)
        self._profile = MotionProfile(start.state, replace(start.bounds, speed=speed))
        super().__init__(start, self._profile, response)
        self._delay_bound = DelayBound(config.delay)
        self._aim = start.state.s
        self._profile.go_to(self._aim)  # where it rests until there is room

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
