# SPDX-License-Identifier: BSD-3-Clause
"""What a joint servo makes of a stream of set-points: checks, a smooth course, its own stop.

Set-points are played a few milliseconds late, joined by cubic Hermite segments in their own time,
so that the jitter of their arrival never reaches the joints. When none is left the course goes on
at its last speed and with its last bend until they count as stale; then all joints slow down
together along that curve, so that they leave their common path as little as possible: from 50 mm/s
by 1.2 um at the trocar, against 88 um along a straight line in joint space (measured).
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from enum import Enum

import numpy as np

from rst_control.config import ServoConfig
from rst_control.robot import joint_kernels
from rst_control.robot.courses import Brake, Curve, Fade, Joints
from rst_control.types import Cause, Reason, Setpoint

REACHED = 1.001  # times a limit: rounding, and what lies between the places a plan was judged at
ON_TIME = (-np.inf, -np.inf)  # [s] since when set-points at rest are late, and the last of these
START_SHARE = 0.1  # of the joints' greatest speeds, to reach a first set-point that lies elsewhere


class ServoState(Enum):
    """What the servo is doing."""

    HOLDING = "holding"
    FOLLOWING = "following"
    BRAKING = "braking"


@dataclass(frozen=True, eq=False)
class ServoLimits:
    """What the joints can do; each of shape (10,), in the order of JOINTS."""

    names: tuple[str, ...]
    lower: Joints  # [rad]
    upper: Joints  # [rad]
    speed: Joints  # [rad/s]
    acceleration: Joints | None = None  # [rad/s^2] between set-points; None: any


class Servo:
    """Turns set-points into the course of the joints, within limits; a fault brakes and latches.

    Args:
        config: Delays, tolerances and braking.
        limits: Limits of the joints.
        position: Where the joints are at the start [rad]. Shape (10,).
    """

    def __init__(self, config: ServoConfig, limits: ServoLimits, position: Joints) -> None:
        self._config, self._limits = config, limits
        self._deceleration = np.array(config.brake_deceleration)
        self._points: deque[Setpoint] = deque(maxlen=config.buffer)
        self._brake = Brake.standing(position)
        self._still = np.zeros_like(position)
        self._fade = Fade(self._still, 0.0, 0.0)
        self._closed_until = -np.inf  # set-points stamped earlier do not count
        self._late = ON_TIME
        self.state, self.fault = ServoState.HOLDING, ""

    @property
    def newest_stamp(self) -> float:
        """Stamp of the newest set-point in play [s]; minus infinity while there is none."""
        return self._points[-1].stamp if self._points else -np.inf

    @property
    def rest(self) -> Joints | None:
        """Where it holds the joints [rad], shape (10,); None while they are led, or brake."""
        return self._brake.curve.position if self.state is ServoState.HOLDING else None

    def accept(self, point: Setpoint, now: float) -> None:
        """Take one set-point; one that no joint may follow raises a fault instead.

        Set-points are ignored while braking, while a fault is latched, and where they are stale or
        older than the last one. At rest, those of a clock that is behind are a fault as well: far
        behind at once, and less where all of them are stale for as long as `lead`. Nobody else
        would say why the robot stands.
        """
        if self.fault or self.state is ServoState.BRAKING:
            return
        if reason := self._other_clock(point.stamp, now):
            self._refuse(reason, now)
            return
        oldest = max(self._closed_until, self.newest_stamp, now - self._config.stale_after)
        if point.stamp <= oldest:
            self._note_late(point.stamp, now)
            return
        self._late = ON_TIME
        if reason := self._objection(point, now):
            self._refuse(reason, now)
            return
        if self.state is ServoState.HOLDING:
            rest, still = self._brake.at(now)
            speed = START_SHARE * self._limits.speed
            self._fade = Fade.over(rest - point.position, now, speed)
            self._points.append(Setpoint(point.position, still, point.stamp - self._config.period))
            self.state = ServoState.FOLLOWING
        self._points.append(point)

    def _note_late(self, stamp: float, now: float) -> None:
        """Refuse set-points at rest once they have been stale for too long."""
        age, allowed = now - stamp, self._config.stale_after
        if self.state is not ServoState.HOLDING or age < allowed:
            return
        since, last = self._late
        since = now if now - last > self._config.lead else since
        self._late = since, now
        if now - since > self._config.lead:
            words = f"set-points stamped {age:.3f} s in the past for {now - since:.2f} s"
            self._refuse(f"{words}, allowed {allowed:.3f} s", now)

    def _refuse(self, reason: str, now: float) -> None:
        self.fail(Cause(Reason.SETPOINT_REFUSED, reason).coded, now)

    def hold(self, now: float) -> None:
        """Slow down and stay; set-points up to `now`, and up to those in play, do not count.

        A course that ends at rest is played to its end instead, which takes a few milliseconds.
        """
        self._closed_until = max(now, self.newest_stamp)
        if self.state is ServoState.FOLLOWING and not self._ends_at_rest():
            self._start_braking(now)

    def fail(self, reason: str, now: float) -> None:
        """Latch a fault, slow down and stay. The first reason is the one that is kept.

        Args:
            reason: In words, or as `Cause.coded`.
            now: Time [s].
        """
        self.fault = self.fault or reason
        self.hold(now)

    def stand_at(self, position: Joints) -> None:
        """Take over where the joints truly stand [rad], shape (10,), unless they are led."""
        if self.state is ServoState.HOLDING:
            self._rest(np.array(position))

    def clear_fault(self) -> bool:
        """Take set-points again.

        Returns:
            False where the joints have not come to rest yet.
        """
        if self.state is not ServoState.HOLDING:
            return False
        self.fault = ""
        return True

    def course(self, now: float) -> tuple[Joints, Joints]:
        """Where the joints should be and how fast they should move.

        Args:
            now: Time [s]; must not go back from call to call.

        Returns:
            Position [rad] and velocity [rad/s], each of shape (10,).
        """
        if (
            self.state is ServoState.FOLLOWING
            and now - self.newest_stamp > self._config.stale_after
        ):
            self._go_stale(now)
        if self.state is ServoState.FOLLOWING:
            position, velocity = self._played(now - self._config.playout_delay)
        else:
            position, velocity = self._brake.at(now)
        if not self._fade.is_over(now):
            away, speed = self._fade.at(now)
            position, velocity = position + away, velocity + speed
        position = joint_kernels.clamped(position, self._limits.lower, self._limits.upper)
        is_braked = now >= self._brake.start + self._brake.duration and self._fade.is_over(now)
        if self.state is ServoState.BRAKING and is_braked:
            self._rest(position)
        return position, velocity

    def bend(self, now: float) -> Joints:
        """How the course bends at a time [s], square to its velocity [rad/s^2]. Shape (10,)."""
        if self.state is not ServoState.FOLLOWING:
            return self._brake.curve.bend
        time = now - self._config.playout_delay
        return self._curve(min(time, self.newest_stamp)).bend

    def _go_stale(self, now: float) -> None:
        is_unfinished, age = not self._ends_at_rest(), now - self.newest_stamp
        self._start_braking(now)
        if is_unfinished:
            words = f"set-points stopped coming while moving, {age * 1e3:.0f} ms ago"
            self.fail(Cause(Reason.SETPOINTS_STOPPED, words).coded, now)

    def _ends_at_rest(self) -> bool:
        return bool(np.abs(self._points[-1].velocity).max() <= self._config.rest_speed)

    def _start_braking(self, now: float) -> None:
        time = now - self._config.playout_delay
        last = min(time, self.newest_stamp)  # exactly: a rounding beyond it has no set-point
        begun, curve = time - last, self._curve(last)
        pull = self._deceleration - np.minimum(np.abs(curve.bend), 0.5 * self._deceleration)
        duration = float(np.max(1.5 * np.abs(curve.at(begun)[1]) / pull))
        position = curve.at(begun)[0]
        still = duration == 0.0
        self._brake = Brake.standing(position) if still else Brake(curve, begun, now, duration)
        self._points.clear()
        self.state = ServoState.BRAKING

    def _rest(self, position: Joints) -> None:
        self._brake = Brake.standing(position)
        self.state = ServoState.HOLDING

    def _played(self, time: float) -> tuple[Joints, Joints]:
        while len(self._points) > 3 and self._points[2].stamp <= time:
            self._points.popleft()
        if time > self.newest_stamp:
            return self._curve(self.newest_stamp).at(time - self.newest_stamp)
        return self._between(time)

    def _between(self, time: float) -> tuple[Joints, Joints]:
        points = self._points
        if time <= points[0].stamp:
            return points[0].position, points[0].velocity
        after = 1
        while points[after].stamp < time:
            after += 1
        return _hermite(points[after - 1], points[after], time)

    def _curve(self, time: float) -> Curve:
        """The course at a time within the set-points, and how it bends there."""
        position, velocity = self._between(time)
        squared = float(velocity @ velocity)
        if squared <= self._config.rest_speed**2:
            return Curve(position, velocity, np.zeros_like(velocity))
        change = (velocity - self._between(time - self._config.period)[1]) / self._config.period
        bend = change - (change @ velocity / squared) * velocity
        return Curve(position, velocity, np.clip(bend, -self._deceleration, self._deceleration))

    def _other_clock(self, stamp: float, now: float) -> str:
        """Whether a stamp is of another clock; in motion an old one may have been held up."""
        ahead, allowed = stamp - now, self._config.lead
        is_behind = self.state is ServoState.HOLDING and ahead < -allowed
        if not is_behind and ahead <= allowed:
            return ""
        where = "past" if is_behind else "future"
        return f"set-point stamped {abs(ahead):.3f} s in the {where}, allowed {allowed:.3f} s"

    def _objection(self, point: Setpoint, now: float) -> str:
        limits = self._limits
        j = joint_kernels.outside(point.position, limits.lower, limits.upper)
        if j >= 0:
            return (
                f"{limits.names[j]} set-point {point.position[j]:.4f} rad, "
                f"allowed {limits.lower[j]:.4f} to {limits.upper[j]:.4f}"
            )
        if self.state is ServoState.HOLDING:
            j, away = joint_kernels.furthest(point.position, self._brake.at(now)[0])
            if away > self._config.start_tolerance:
                return (
                    f"{limits.names[j]} starts {away:.4f} rad away from where it holds, "
                    f"allowed {self._config.start_tolerance:.4f}"
                )
        return self._too_fast(point)

    def _too_fast(self, point: Setpoint) -> str:
        allowed, period = self._limits.speed, self._config.period
        last = self._points[-1] if self._points else point
        span = max(point.stamp - last.stamp, period)  # stamps may jitter
        j, speed = joint_kernels.fastest(
            point.position, point.velocity, last.position, span, allowed
        )
        if speed <= REACHED * allowed[j]:
            return self._too_sudden(point, span)
        return (
            f"{self._limits.names[j]} set-point speed {speed:.3f} rad/s, allowed {allowed[j]:.3f}"
        )

    def _too_sudden(self, point: Setpoint, span: float) -> str:
        """Whether the speed changes faster than the joints can: they would leave their course."""
        allowed = self._limits.acceleration
        if allowed is None:
            return ""
        last = self._points[-1].velocity if self._points else self._still
        j, change = joint_kernels.fastest(point.velocity, self._still, last, span, allowed)
        if change <= REACHED * allowed[j]:
            return ""
        name = self._limits.names[j]
        return f"{name} set-point acceleration {change:.2f} rad/s^2, allowed {allowed[j]:.2f}"


def warm_up(config: ServoConfig, limits: ServoLimits) -> None:
    """Compile or load all that a servo calls, by leading one along set-points that stand still."""
    middle = 0.5 * (limits.lower + limits.upper)
    servo, still, now = Servo(config, limits, middle), np.zeros_like(middle), 0.0
    while now < config.playout_delay + 3.0 * config.period:
        servo.course(now)
        servo.accept(Setpoint(middle, still, now), now)
        now += config.period


def _hermite(first: Setpoint, second: Setpoint, time: float) -> tuple[Joints, Joints]:
    course = joint_kernels.hermite(
        first.position,
        first.velocity,
        first.stamp,
        second.position,
        second.velocity,
        second.stamp,
        time,
    )
    return course[0], course[1]
