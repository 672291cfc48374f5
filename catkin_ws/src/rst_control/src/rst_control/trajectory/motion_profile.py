# SPDX-License-Identifier: BSD-3-Clause
"""Jerk-limited motion of one number: to a target that may change, to a speed, or to rest.

By Ruckig (L. Berscheid and T. Kroeger, Jerk-limited Real-time Trajectory Generation with Arbitrary
Target States, RSS 2021).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import ruckig

from rst_control.errors import RstError
from rst_control.types import PathState


@dataclass(frozen=True)
class MotionBounds:
    """What a profile keeps; metres on a path, radians for jaws."""

    speed: float  # [m/s]
    acceleration: float  # [m/s^2]
    jerk: float  # [m/s^3]


class MotionProfileError(RstError):
    """Ruckig found no profile; the numbers asked for make none possible."""

    def __init__(self, state: PathState, bounds: MotionBounds, why: str) -> None:
        super().__init__(f"no profile from {state} within {bounds}: {why}")
        self.state, self.bounds = state, bounds


class MotionProfile:
    """Motion of s; each change of target or mode goes on from the present speed and acceleration.

    It has to be given a target, a speed or `brake` before it moves.

    Args:
        state: Where it starts.
        bounds: Speed, acceleration and jerk that it keeps.
    """

    def __init__(self, state: PathState, bounds: MotionBounds) -> None:
        self.bounds = bounds
        self._solver = ruckig.Ruckig(1)
        self._planned: ruckig.Trajectory | None = None
        self._state = state
        self._time = 0.0

    @classmethod
    def braking(cls, state: PathState, bounds: MotionBounds) -> MotionProfile:
        """Come to rest from a state as soon as the bounds allow.

        An acceleration that still makes it faster is cut at once, not faded out.
        """
        is_pushing = state.speed * state.acceleration > 0.0
        profile = cls(PathState(state.s, state.speed) if is_pushing else state, bounds)
        profile.brake()
        return profile

    @property
    def state(self) -> PathState:
        """Where s is now."""
        return self._state

    @property
    def is_done(self) -> bool:
        """Whether s rests at the target, or at rest after braking."""
        return self._time >= self._trajectory.duration

    @property
    def remaining(self) -> float:
        """Time until it is done [s]."""
        return max(0.0, float(self._trajectory.duration) - self._time)

    @property
    def end(self) -> float:
        """Where s will be once done [m]."""
        return float(self._trajectory.at_time(self._trajectory.duration)[0][0])

    def go_to(self, target: float, bounds: MotionBounds | None = None) -> None:
        """Head for a target and stop there, from the present motion; may change the bounds."""
        self.bounds = bounds or self.bounds
        request = self._request(self.bounds)
        request.target_position = [target]
        self._plan(request)

    def go_at(self, speed: float, bounds: MotionBounds | None = None) -> None:
        """Change to a speed [m/s] as fast as the bounds allow; may change the bounds."""
        self.bounds = bounds or self.bounds
        request = self._request(self.bounds)
        request.control_interface = ruckig.ControlInterface.Velocity
        request.target_velocity = [speed]
        self._plan(request)

    def brake(self) -> None:
        """Come to rest as soon as the bounds allow."""
        self.go_at(0.0)

    def step(self, dt: float) -> PathState:
        """Move on by a time [s]; returns the state then."""
        self._time += dt
        duration = self._trajectory.duration
        (s,), (speed,), (acceleration,) = self._trajectory.at_time(self._time)
        if self._time >= duration and abs(speed) < 1e-12:
            speed = acceleration = 0.0
        self._state = PathState(s, speed, acceleration)
        return self._state

    def _request(self, bounds: MotionBounds) -> ruckig.InputParameter:
        request = ruckig.InputParameter(1)
        request.current_position = [self._state.s]
        request.current_velocity = [self._state.speed]
        request.current_acceleration = [self._state.acceleration]
        request.max_velocity = [bounds.speed]
        request.max_acceleration = [bounds.acceleration]
        request.max_jerk = [bounds.jerk]
        return request

    def _plan(self, request: ruckig.InputParameter) -> None:
        trajectory = ruckig.Trajectory(1)
        try:
            outcome = self._solver.calculate(request, trajectory)
        except ruckig.RuckigError as error:
            raise MotionProfileError(self._state, self.bounds, str(error)) from error
        if outcome not in (ruckig.Result.Working, ruckig.Result.Finished):
            raise MotionProfileError(self._state, self.bounds, str(outcome))
        self._planned, self._time = trajectory, 0.0

    @property
    def _trajectory(self) -> ruckig.Trajectory:
        if self._planned is None:
            raise MotionProfileError(self._state, self.bounds, "it has no target yet")
        return self._planned


def stopping_speed(bounds: MotionBounds, time: float, distance: float) -> float:
    """Highest speed from which braking keeps a time [s] and a distance [m]; at most `bounds.speed`.

    Braking takes v / a + a / j and half of v times that: the trapezoid of acceleration, which is
    an upper bound where the full acceleration is never reached.
    """
    ramp = bounds.acceleration / bounds.jerk
    in_time = bounds.acceleration * (time - ramp)
    half = 0.5 * bounds.acceleration * ramp
    in_distance = math.sqrt(half * half + 2.0 * bounds.acceleration * distance) - half
    if in_time < half:  # the jerk alone takes longer than that
        in_time = 0.25 * bounds.jerk * time * time
    return min(bounds.speed, in_time, in_distance)
