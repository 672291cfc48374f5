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
from rst_control.types import Measurement, PathState, Vector

SAME_AIM = 1e-6  # [m]


class GuardedPull(TowardsTension):
    """Goes along a path until the tension is that of the phase, or to the furthest s.

    It is as slow as lets the stiffest tissue expected rise by no more than the tolerance within
    the delay of the tension, and stops earlier by what the tension rose by within the last delay.
    One reading is enough to stop. So it looks again at rest, and goes on where that reading was
    an outlier: where the mean of a rest is short of the goal by more than the tolerance.
    The first reading, which gives the direction, may be the outlier. So near its start the mean
    of a rest gives the direction anew.

    Args:
        start: How it begins; its phase has a tension.
        config: Of the tension.
        response: Of the tissue held.
    """

    def __init__(self, start: PhaseStart, config: TensionConfig, response: GraspResponse) -> None:
        rise = max(config.delay, 1e-3) * config.blind_stiffness  # [N s/m]
        speed = min(start.bounds.speed, config.tolerance / rise)
        self._bounds, self._config = replace(start.bounds, speed=speed), config
        self._profile = MotionProfile(start.state, self._bounds)
        super().__init__(start, self._profile, response)
        self.phase = replace(self.phase, speed=speed)  # by which its time is judged
        self._delay_bound = DelayBound(config.delay)
        self._near = speed * config.delay  # [m] on which the tension may change unnoticed
        self._rest: _Rest | None = None  # in which it looks again
        self._aim = start.state.s
        self._profile.go_to(self._aim)  # where it rests until there is room

    def step(self, dt: float, measured: Measurement) -> tuple[Vector, Vector]:
        """Move on by a time [s]; see `PhaseExecution`."""
        self._delay_bound.update(measured.stamp, measured.tension)
        if self._feel(measured.tension):
            self.is_pulling = self._goal > measured.tension
        if self._brake is not None:
            state = self._brake.step(dt)
            self.is_done = self._brake.is_done
            return self._joints(state)
        state = self._go(dt, measured) if self._rest is None else self._look(dt, self._rest)
        self.failure = self._objection(measured)
        if self.failure:
            self._brake_from(state)
        return self._joints(state)

    def _go(self, dt: float, measured: Measurement) -> PathState:
        """Go on by a time [s], to the end or as far as the response of the tissue allows."""
        end = self._end
        aim = min(end, self._room_ends(measured))
        if abs(aim - self._aim) > SAME_AIM or (aim == end != self._aim):
            self._aim = aim
            self._profile.go_to(aim)
        state = self._profile.step(dt)
        is_at_end = self._profile.is_done and self._aim == end
        self.is_done = is_at_end and not self._is_near_start(state)
        if (self._is_reached or is_at_end) and not self.is_done:
            self._profile = self._course = MotionProfile.braking(state, self._start.brakes)
            self._rest = _Rest(self._config.delay)
        return state

    def _look(self, dt: float, rest: _Rest) -> PathState:
        """Come to rest, see what the tension is there, and go on or be done."""
        state = self._profile.step(dt)
        if not self._profile.is_done:
            return state
        tension = rest.mean(dt, self._now)
        if tension is None:
            return state
        if self._is_near_start(state):
            self.is_pulling = self._goal > tension
        missing = self._goal - tension if self.is_pulling else tension - self._goal
        is_at_end = abs(self._end - state.s) <= SAME_AIM
        self.is_done = is_at_end or missing <= self._config.tolerance
        if not self.is_done:
            self._rest, self._aim = None, state.s
            self._profile = self._course = MotionProfile(state, self._bounds)
            self._profile.go_to(self._aim)
            self._delay_bound.forget()
        return state

    def _is_near_start(self, state: PathState) -> bool:
        return abs(state.s - self._start.state.s) <= self._near

    @property
    def _end(self) -> float:
        """Where the way ends in its direction [m]."""
        return self._furthest if self.is_pulling else 0.0

    @property
    def _is_reached(self) -> bool:
        if self.is_pulling:
            return self._now + self._delay_bound.ahead >= self._goal
        return self._now <= self._goal


class _Rest:
    """Mean of the readings at rest that are not late any more.

    Args:
        delay: By which the measured tension is late [s].
    """

    def __init__(self, delay: float) -> None:
        self._delay, self._time = delay, 0.0
        self._sum, self._count = 0.0, 0

    def mean(self, dt: float, tension: float) -> float | None:
        """Take in the tension [N] a time [s] later; the mean [N], once the rest was long enough."""
        self._time += dt
        if self._time >= self._delay:
            self._sum, self._count = self._sum + tension, self._count + 1
        return self._sum / self._count if self._time >= 2.0 * self._delay else None
