# SPDX-License-Identifier: BSD-3-Clause
"""Leads the arm along its course by joint velocities, sent every 25 ms and kept until the next.

Each velocity is the one with which the arm, from where it is predicted to be, reaches the next
place of the course one period later. So all joints go along a chord of their common path: the shaft
leaves the trocar by the chord's height only, and lateness of one period sent is made up for by the
next. Predicted is by what was sent and by how fast the driver lets each joint change its velocity
(`velocity_ramp.py`). Where the feedback, which is late and seldom, says otherwise, the difference
is made up for slowly, all joints at the same rate, so that this, too, goes along the path where its
cause is nothing but another lag than was thought.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from rst_control.kinova.brake_plan import LastCourse
from rst_control.kinova.config import ArmConfig
from rst_control.kinova.feedback import JointFeedback
from rst_control.kinova.velocity_ramp import Ramp, catching_up, feasible_share, velocity_for
from rst_control.types import Vector

MEMORY = 1.0  # [s] of what was sent; above the lag and the age of the feedback
STILL = 2e-4  # [rad/s] of all joints, below which an arm that should stand is sent zeros
SPARE = 0.4  # share of the acceleration that plans leave, for catching up with the course
LAG_CHANGE = 0.002  # [rad/s] from feedback to feedback, from which motion shows the lag
LAG_MEMORY = 0.98  # share of what was learnt of the lag that each such feedback leaves


class Follower:
    """Makes velocities for the arm; `objection` names a joint that does not follow.

    Args:
        config: Period, lag, gains and tolerances.
        speed: Greatest speed of each joint [rad/s]. Shape (7,).
    """

    def __init__(self, config: ArmConfig, speed: Vector) -> None:
        self._config, self._speed = config, np.array(speed, dtype=float)
        self._acceleration = np.array(config.acceleration)
        self._past: deque[Ramp] = deque()  # what was sent, the newest last
        self._correction = np.zeros(len(speed))  # [rad] that the arm is sent beyond the course
        self._drift = np.zeros(len(speed))  # [rad] of the arm from what it was sent
        self._goal = np.zeros(len(speed))
        self._standing_since = np.inf  # [s] when the course came to rest
        self._lag_sum, self._last_speed = np.zeros(2), np.zeros(len(speed))
        self.objection = ""

    @property
    def lag(self) -> float:
        """From a velocity sent to its motion in the feedback, as seen so far [s]."""
        way, square = self._lag_sum.tolist()
        return self._config.lag - (way / square if square > 0.0 else 0.0)

    @property
    def off(self) -> float:
        """Of the joint furthest off its predicted course [rad]."""
        return float(np.abs(self._drift + self._correction).max())

    def start(self, position: Vector, now: float) -> None:
        """Begin to lead the arm, which stands at a position [rad]; shape (7,)."""
        still = np.zeros_like(self._drift)
        self._past = deque([Ramp(now, np.array(position), still, still, self._acceleration)])
        self._correction, self._drift, self._last_speed = still.copy(), still.copy(), still
        self._goal, self._standing_since = np.array(position), now
        self.objection = ""

    def last_course(self, speed: Vector, bend: Vector) -> LastCourse | None:
        """What the newest velocity leaves behind; None: none was sent.

        Args:
            speed: Of the course at its goal [rad/s]. Shape (7,).
            bend: Of the course there [rad/s^2]. Shape (7,).
        """
        if not self._past:
            return None
        ramp, goal = self._past[-1], self._goal + self._correction
        return LastCourse(ramp.begun, ramp.position, ramp.velocity, ramp.wanted, goal, speed, bend)

    def leave(self) -> None:
        """Lead it no longer."""
        self._past.clear()

    def update(self, feedback: JointFeedback) -> None:
        """Compare what the arm says with what it was sent."""
        if not self._past:
            return
        expected, speed = self._at(feedback.stamp - self._config.lag)
        drift = feedback.position - expected
        self._learn_lag(drift - self._drift, speed - self._last_speed)
        self._drift, self._last_speed = drift, speed
        self._check(feedback)

    def step(self, goal: Vector, now: float) -> Vector:
        """Velocities [rad/s] to be sent now, shape (7,).

        Args:
            goal: Where the arm should be one period from now [rad]. Shape (7,).
            now: Time [s].
        """
        if not np.array_equal(goal, self._goal):
            self._standing_since = now
        ahead, self._goal = goal - self._goal, np.array(goal)
        self._correct()
        place, velocity = self._past[-1].at(now)
        behind = goal + self._correction - place - ahead
        way = ahead + catching_up(behind, SPARE * self._acceleration, self._config.period) * behind
        wanted = self._wanted(way, velocity, now > self._standing_since)
        wanted = wanted.astype(np.float32).astype(float)  # as the message carries it
        self._past.append(Ramp(now, place, velocity, wanted, self._acceleration))
        while len(self._past) > 1 and self._past[1].begun < now - MEMORY:
            self._past.popleft()
        return wanted

    def _wanted(self, way: Vector, velocity: Vector, is_standing: bool) -> Vector:
        period = self._config.period
        if is_standing and np.abs(way).max() < STILL * period and not velocity.any():
            return np.zeros_like(way)
        way = way * feasible_share(way, velocity, self._acceleration, period)
        wanted = velocity_for(way, velocity, self._acceleration, period)
        most = float((np.abs(wanted) / self._speed).max())
        return wanted / most if most > 1.0 else wanted  # slower together, in the same direction

    def _correct(self) -> None:
        """Let the correction tend to what the arm is off."""
        config = self._config
        change = -config.gain * (self._drift + self._correction)
        fastest = float(np.abs(change).max())
        if fastest > config.correction_speed:
            change *= config.correction_speed / fastest
        self._correction = self._correction + config.period * change

    def _at(self, time: float) -> tuple[Vector, Vector]:
        """Place [rad] and velocity [rad/s] that what was sent up to a time [s] leads to then."""
        for ramp in reversed(self._past):
            if ramp.begun <= time:
                return ramp.at(time)
        return self._past[0].at(time)

    def _learn_lag(self, drifted: Vector, faster: Vector) -> None:
        """From changes alone, so that an arm that stands a little elsewhere shows no lag."""
        if np.abs(faster).max() >= LAG_CHANGE:
            shown = np.array([drifted @ faster, faster @ faster])
            self._lag_sum = LAG_MEMORY * self._lag_sum + shown

    def _check(self, feedback: JointFeedback) -> None:
        config, off = self._config, self._drift + self._correction
        joint = int(np.abs(off).argmax())
        name = config.joints[joint]
        if abs(off[joint]) > config.following_error:
            self._object(
                f"{name} {off[joint]:+.4f} rad off the course that it was sent on, "
                f"allowed {config.following_error:.4f}"
            )
        joint = int(np.abs(self._correction).argmax())
        if abs(self._correction[joint]) > config.max_correction:
            self._object(
                f"{config.joints[joint]} went {-self._correction[joint]:+.4f} rad further than it "
                f"was sent, allowed {config.max_correction:.4f}"
            )
        if feedback.stamp - self._standing_since > config.settle_time + config.lag:
            self._check_end(feedback)

    def _check_end(self, feedback: JointFeedback) -> None:
        """The driver reports success wherever the arm stands; so it is checked here."""
        away = feedback.position - self._goal
        joint = int(np.abs(away).argmax())
        if abs(away[joint]) > (allowed := self._config.end_tolerance):
            self._object(
                f"{self._config.joints[joint]} ended {away[joint]:+.4f} rad off where it was "
                f"sent, allowed {allowed:.4f}"
            )

    def _object(self, words: str) -> None:
        self.objection = self.objection or words
