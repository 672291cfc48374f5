# SPDX-License-Identifier: BSD-3-Clause
"""Speed along the pull path from the tension's error, as fast as the tissue's stiffness permits.

A pull starts as if the tissue were the stiffest allowed, and speeds up once it is measured to be
softer. So stiff tissue is not torn, and soft tissue is not pulled needlessly slowly. Loaded tissue
may stiffen tenfold at any moment, and the pull still stops below the tension's limit.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace

from rst_control.config import TensionConfig
from rst_control.tension.stiffness import STIFFENING, StiffnessEstimate
from rst_control.trajectory.motion_profile import MotionBounds, MotionProfile
from rst_control.types import PathState

BRAKING_SHARE = 0.5  # of the acceleration that the approach to a target counts on
TRUST = 20.0  # [1/s] how fast tissue is taken for softer; for stiffer it is taken at once
LATE = 2.0  # times the delay of the tension that stopping allows for
LOADED = 4.0  # times the noise of the tension, above which tissue counts as taut
SLACK_SHARE = 0.4  # of the way to the target, in which a slack pull can stop on the stiffest tissue
END_REACHED = 1e-6  # [m]
AT_REST = 2e-4  # [m/s]
MIN_SPEED = 1e-7  # [m/s] below which it stands


class TensionControl:
    """Moves s until the tension has its target, or the pull path ends.

    Args:
        config: Target tolerance, bandwidth, stiffness range, delay and noise of the tension.
        bounds: Speed, acceleration and jerk along the path.
        brakes: The same of a stop.
        length: Where the pull path ends [m].
        state: Where s is; 0 where the tissue was grasped.
        target: Tension to reach [N].
    """

    def __init__(
        self,
        config: TensionConfig,
        bounds: MotionBounds,
        brakes: MotionBounds,
        length: float,
        state: PathState,
        target: float,
    ) -> None:
        self._config, self._bounds, self._brakes = config, bounds, brakes
        self._length = length
        self._profile = MotionProfile(state, bounds)
        self._estimate = StiffnessEstimate(*config.stiffness_range, config.noise)
        self._past = deque([(0.0, state.s)])  # times and places, back to when the tension arose
        self._time = self._settled_for = self._at_end_for = 0.0
        self._is_braking_hard = False
        self._cautious = self._estimate.cautious  # [N/m] that the speed reckons with
        self.tension = 0.0  # [N] now, as far as noise and delay can be made up for
        self.is_pulling = False  # s went forward, or is to, and has not turned to ease since
        self.target = target
        self.bound = math.inf  # [m] that s may not pass for now

    @property
    def state(self) -> PathState:
        """Where s is now."""
        return self._profile.state

    @property
    def is_settled(self) -> bool:
        """Whether the tension has been within tolerance of its target for the time asked."""
        return 0.0 < self._settled_for >= self._config.settle_time

    @property
    def is_at_limit(self) -> bool:
        """Whether s has rested at an end of the path, short of its target, for the time asked."""
        is_short = abs(self.target - self.tension) > self._config.tolerance
        return is_short and 0.0 < self._at_end_for >= self._config.settle_time

    def step(self, force: float, dt: float) -> PathState:
        """Move on by dt [s] with the tension [N] measured now; returns the state of s then."""
        self._update(force, dt)
        error = self._error()
        is_close = abs(error) <= self._config.tolerance
        self._settled_for = self._settled_for + dt if is_close else 0.0
        self._set_speed(error)
        state = self._profile.step(dt)
        self._past.append((self._time, state.s))
        self._judge_course(self.target - self.tension, dt)
        return state

    def _judge_course(self, missing: float, dt: float) -> None:
        """See where s goes, with a tension missing [N], and how long it has rested at its end [s].

        One reading may be an outlier. So none decides for the whole pull, or ends it.
        """
        s, speed = self.state.s, self.state.speed
        if speed > 0.0 or (speed == 0.0 and missing > 0.0):
            self.is_pulling = True
        elif missing < -self._config.tolerance:
            self.is_pulling = False
        end = self._length if missing > 0.0 else 0.0
        is_at_end = abs(end - s) <= END_REACHED and abs(speed) <= AT_REST
        self._at_end_for = self._at_end_for + dt if is_at_end else 0.0

    def _update(self, force: float, dt: float) -> None:
        """Take in the measured tension, which arose where s was a while ago."""
        past, state, estimate = self._past, self.state, self._estimate
        self._time += dt
        while len(past) > 1 and past[1][0] <= self._time - self._config.delay:
            past.popleft()
        seen = past[0][1]
        estimate.update(seen, force, abs(state.speed))
        trusted = self._cautious * math.exp(-TRUST * dt)
        self._cautious = max(estimate.cautious, trusted)
        self.tension = max(0.0, estimate.force + estimate.value * (state.s - seen))
        if self._is_slack:  # slack tissue says nothing of how stiff it is once taut
            self._cautious = max(self._cautious, estimate.highest)

    @property
    def _is_slack(self) -> bool:
        return self.tension < LOADED * self._config.noise

    def _error(self) -> float:
        """Tension that is missing [N]; what is only forecast may stop s, but not turn it round."""
        now, seen = self.target - self.tension, self.target - self._estimate.force
        return now if now * seen > 0.0 else 0.0

    def _set_speed(self, error: float) -> None:
        """Set the speed that fits now; brake hard where the limit is near."""
        speed, state = min(self._bounds.speed, self._approach_speed(error)), self.state
        safe = self._limit_speed() if error > 0.0 else speed
        # A hard deceleration needs its jerk until it has ended, else it would throw s back.
        is_slowing = self._is_braking_hard and state.acceleration < 0.0
        self._is_braking_hard = is_slowing or safe < min(speed, state.speed)
        bounds = self._brakes if self._is_braking_hard else self._bounds
        if min(speed, safe) < MIN_SPEED:
            self._profile.go_at(0.0, bounds)
        else:
            self._profile.go_to(self._end(error), replace(bounds, speed=min(speed, safe)))

    def _approach_speed(self, error: float) -> float:
        """Speed at which the tension comes near its target without passing it [m/s]."""
        if error > 0.0 and self._is_slack:
            return self._stopping_speed(SLACK_SHARE * error / self._estimate.highest, self._bounds)
        way = abs(error) / self._cautious
        return min(self._config.bandwidth * way, self._stopping_speed(way, self._bounds))

    def _limit_speed(self) -> float:
        """Speed from which it stops below the limit though the tissue stiffen at once [m/s]."""
        room = max(0.0, self._config.limit - self.tension)
        return self._stopping_speed(room / (STIFFENING * self._cautious), self._brakes)

    def _stopping_speed(self, way: float, bounds: MotionBounds) -> float:
        """Speed v from which it stops within a way [m], the delay of the tension included [m/s].

        The way is v * t + v^2 / (2 a), where t is the delay and half of the time in which the
        acceleration a builds up.
        """
        acceleration = BRAKING_SHARE * bounds.acceleration
        lost = LATE * self._config.delay + 0.5 * bounds.acceleration / bounds.jerk
        gained = acceleration * lost
        return math.sqrt(gained * gained + 2.0 * acceleration * way) - gained

    def _end(self, error: float) -> float:
        return min(self._length, self.bound) if error > 0.0 else 0.0
