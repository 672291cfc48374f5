# SPDX-License-Identifier: BSD-3-Clause
"""Speed along the pull path from the tension's error: its gain follows the tissue's stiffness.

A pull starts as if the tissue were the stiffest allowed, and speeds up as the measured slope of
tension over displacement shows it to be softer; so stiff tissue is not torn and soft tissue is
not waited for.
"""

from __future__ import annotations

import math
from collections import deque

from rst_control.config import TensionConfig
from rst_control.profile import Bounds, Profile
from rst_control.types import PathState

SLOPE_DISTANCE = 1e-4  # [m] of displacement over which the stiffness is measured
LEAST_SLOPE_DISTANCE = 2e-5  # [m] below which its measurement means nothing
TRUST_FALL = (
    12.0  # [1/s] how fast the estimate follows towards softer tissue; stiffer counts at once
)
BRAKING_SHARE = 0.5  # of the acceleration that the approach to a target counts on
END_GAIN = 20.0  # [1/s] of the approach to the end of the path
END_REACHED = 2e-5  # [m]
AT_REST = 2e-4  # [m/s]


class StiffnessEstimate:
    """Slope of tension over displacement, measured as the tissue is pulled.

    Args:
        lowest: Never below [N/m].
        highest: Where it starts, and never above [N/m].
    """

    def __init__(self, lowest: float, highest: float) -> None:
        self._lowest, self._highest = lowest, highest
        self._window: deque[tuple[float, float]] = deque(maxlen=500)
        self.value = highest  # [N/m]

    def update(self, s: float, force: float, dt: float) -> float:
        """Take in one pair of displacement [m] and tension [N]; returns the estimate [N/m]."""
        window = self._window
        window.append((s, force))
        while len(window) > 2 and abs(s - window[1][0]) > SLOPE_DISTANCE:
            window.popleft()
        travelled = s - window[0][0]
        if abs(travelled) < LEAST_SLOPE_DISTANCE:
            return self.value
        slope = (force - window[0][1]) / travelled
        slope = min(max(slope, self._lowest), self._highest)
        if slope > self.value:
            self.value = slope
        else:
            self.value *= (slope / self.value) ** min(1.0, TRUST_FALL * dt)
        return self.value


class TensionControl:
    """Moves s until the tension has its target, or the pull path ends.

    Args:
        config: Target tolerance, bandwidth and stiffness range.
        bounds: Speed, acceleration and jerk along the path.
        length: Of the pull path [m].
        state: Where s is.
        target: Tension to reach [N].
    """

    def __init__(
        self, config: TensionConfig, bounds: Bounds, length: float, state: PathState, target: float
    ) -> None:
        self._config, self._bounds, self._length = config, bounds, length
        self._profile = Profile(state, bounds)
        self._estimate = StiffnessEstimate(*config.stiffness_range)
        self._settled_for = 0.0
        self._error = math.inf
        self.target = target

    @property
    def state(self) -> PathState:
        """Where s is now."""
        return self._profile.state

    @property
    def stiffness(self) -> float:
        """Estimate of the tissue's stiffness along the path [N/m]."""
        return self._estimate.value

    @property
    def is_settled(self) -> bool:
        """Whether the tension has been within tolerance of its target for the time asked."""
        return self._settled_for >= self._config.settle_time

    @property
    def is_at_limit(self) -> bool:
        """Whether s rests at an end of the path, short of its target."""
        state = self.state
        if abs(state.speed) > AT_REST or abs(self._error) <= self._config.tolerance:
            return False
        room = self._length - state.s if self._error > 0.0 else state.s
        return room <= 2.0 * END_REACHED

    def retarget(self, target: float) -> None:
        """Ask for another tension [N], also while moving."""
        self.target, self._settled_for = target, 0.0

    def step(self, force: float, dt: float) -> PathState:
        """Move on by dt [s] with the tension [N] measured now; returns the state of s then."""
        self._error = self.target - force
        self._estimate.update(self.state.s, force, dt)
        self._profile.go_at(self._wanted_speed())
        is_close = abs(self._error) <= self._config.tolerance
        self._settled_for = self._settled_for + dt if is_close else 0.0
        return self._profile.step(dt)

    def _wanted_speed(self) -> float:
        distance = self._error / self.stiffness
        speed = self._approach(abs(distance), self._config.bandwidth)
        room = self._length - self.state.s if distance > 0.0 else self.state.s
        speed = min(speed, self._approach(max(0.0, room - END_REACHED), END_GAIN))
        return math.copysign(speed, distance)

    def _approach(self, distance: float, gain: float) -> float:
        braking = math.sqrt(2.0 * BRAKING_SHARE * self._bounds.acceleration * distance)
        return min(self._bounds.speed, gain * distance, braking)
