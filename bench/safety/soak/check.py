# SPDX-License-Identifier: BSD-3-Clause
"""The invariants of the soak, checked at every tick of the control loop.

They check the set-points that were sent, the true joints and the true tension, and the state that
the controller shows. What the controller believes of the robot is not used.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rst_control.commands.request import Plan
from rst_control.commands.spec import Load
from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.planning.patient_surface import TrocarPose
from rst_control.robot.setpoint_servo import ServoLimits
from rst_control.types import IN_MOTION, ControllerMode, Setpoint, State

Array = NDArray[np.float64]
KEPT = 20  # violations that are described; all are counted
ROUNDING = 1e-9  # [rad], [rad/s]
SHARE = 1e-6  # of a limit, for rounding
SETTLED = 0.05  # [s] after which nothing that was sent is in play any more


@dataclass(frozen=True, eq=False)
class SoakBounds:
    """What may not be passed."""

    joints: ServoLimits
    acceleration: Array  # (10,), [rad/s^2]
    rcm: float  # [m] of the true shaft from the trocar
    tension: float  # [N] true
    stop: float  # [s] of ticks from a stop until set-points stand still
    reset_time: float  # [s] that a "hey robot" may wait for the robot to be well
    period: float  # [s] of the loop
    resting: float  # [rad/s] of a joint that counts as at rest
    max_periods: int  # of the path that one late tick may catch up with


@dataclass(frozen=True, eq=False)
class CheckedTick:
    """One tick as it was."""

    now: float  # [s]
    before: ControllerSnapshot
    after: ControllerSnapshot
    setpoint: Setpoint | None  # sent now
    position: Array  # (10,), [rad] of the true joints
    velocity: Array  # (10,), [rad/s] of the true joints
    tension: float  # [N] true
    is_servo_braking: bool  # the robot brakes by itself
    was_stopped: bool  # a stop came in before this tick
    said: tuple[str, ...]  # orders that were handed over before this tick
    is_recorded: bool  # when the newest command was verified


@dataclass(frozen=True)
class Violation:
    """An invariant that did not hold."""

    kind: str
    time: float  # [s] of the session
    words: str  # the values, and what was allowed


@dataclass
class Extremes:
    """How near it came."""

    rcm: float = 0.0  # [m] of the true shaft
    planned_rcm: float = 0.0  # [m] of the set-points while a path is followed
    tension: float = 0.0  # [N] true
    speed: float = 0.0  # of the limit, set-points
    acceleration: float = 0.0  # of the limit, set-points
    stop: float = 0.0  # [s] from a stop until set-points stand still


@dataclass
class Checker:
    """Remembers one tick, and names what must not be."""

    bounds: SoakBounds
    trocar_pose: Callable[[Array], TrocarPose]
    violations: list[Violation] = field(default_factory=list)
    counts: Counter[str] = field(default_factory=Counter)
    extremes: Extremes = field(default_factory=Extremes)
    ticks: int = 0
    _sent: Setpoint | None = None
    _stopped: int | None = None  # tick of a stop that has not come to rest yet
    _plan: Plan | None = None
    _woken_until: float = -np.inf  # [s] up to which a "hey robot" may wait for the robot
    _rested: float = 0.0  # [s] since when nothing should move
    _place: tuple[Array, TrocarPose] | None = None

    def __call__(self, moment: CheckedTick) -> None:
        """Check one tick."""
        self.ticks += 1
        self._check_mode(moment)
        self._check_start(moment)
        self._check_setpoint(moment)
        self._check_robot(moment)
        self._sent = moment.setpoint

    def report(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "ticks": self.ticks,
            "violations": dict(self.counts),
            "described": [asdict(v) for v in self.violations],
            "extremes": asdict(self.extremes),
        }

    def _note(self, kind: str, moment: CheckedTick, words: str) -> None:
        self.counts[kind] += 1
        if len(self.violations) < KEPT:
            self.violations.append(Violation(kind, moment.now, words))

    def _check_mode(self, moment: CheckedTick) -> None:
        was, mode = moment.before.mode, moment.after.mode
        way = f"{_words(was)} to {_words(mode)}, orders {moment.said}"
        if mode.state is State.MOVING:
            if was.state not in (State.ACTIVE, State.MOVING):
                self._note("mode: motion from elsewhere than active", moment, way)
            if not mode.is_active:
                self._note("mode: motion while not activated", moment, way)
            if moment.was_stopped:
                self._note("mode: motion goes on after a stop", moment, way)
        woken = self._is_woken(moment)
        if was.is_latched and not mode.is_latched and not woken:
            self._note('mode: latch lifted without "hey robot"', moment, way)
        is_up = was.state is State.STOPPING and mode.state in (State.ACTIVE, State.MOVING)
        if is_up and was.mode_after is not State.ACTIVE and not woken:
            self._note("mode: braking led elsewhere than it should", moment, way)

    def _is_woken(self, moment: CheckedTick) -> bool:
        """A "hey robot" stands that no later stop has made void; it may wait for the robot."""
        if moment.was_stopped:
            self._woken_until = -np.inf
        if "hey robot" in moment.said:
            self._woken_until = moment.now + self.bounds.reset_time
        return moment.now <= self._woken_until

    def _check_start(self, moment: CheckedTick) -> None:
        plan = moment.after.plan
        is_new, self._plan = plan is not None and plan is not self._plan, plan
        if plan is None or not is_new or moment.is_recorded:
            return
        if plan.command.load is Load.LOADS:
            self._note("recording: it advances unrecorded", moment, plan.command.phrase)

    def _check_setpoint(self, moment: CheckedTick) -> None:
        self._follow_stop(moment)
        sent, last = moment.setpoint, self._sent
        if sent is None:
            return
        self._check_limits(moment, sent)
        if last is None:
            return
        moved = np.abs(sent.position - last.position)
        is_still = not (moved.any() or sent.velocity.any() or last.velocity.any())
        if is_still or self._is_taken_anew(moment, sent):
            return
        states = (moment.before.mode.state, moment.after.mode.state)
        if not any(state in IN_MOTION for state in states):
            if moved.any() or sent.velocity.any():
                words = f"{moved.max():.2e} rad in {states[1].value}"
                self._note("mode: set-point changes at rest", moment, words)
            return
        self._check_course(moment, sent, last, moved)

    def _is_taken_anew(self, moment: CheckedTick, sent: Setpoint) -> bool:
        """The set-point was set to where the joints were measured, which is no motion."""
        measured = moment.after.measurement
        return (
            measured is not None
            and not sent.velocity.any()
            and np.array_equal(sent.position, measured.position)
        )

    def _check_limits(self, moment: CheckedTick, sent: Setpoint) -> None:
        limits = self.bounds.joints
        beyond = np.maximum(limits.lower - sent.position, sent.position - limits.upper)
        if (worst := int(beyond.argmax())) >= 0 and beyond[worst] > ROUNDING:
            words = f"{limits.names[worst]} by {beyond[worst]:.2e} rad"
            self._note("joint limits: set-point beyond them", moment, words)

    def _check_course(
        self, moment: CheckedTick, sent: Setpoint, last: Setpoint, moved: Array
    ) -> None:
        bounds = self.bounds
        periods = max(1, min(bounds.max_periods, round((sent.stamp - last.stamp) / bounds.period)))
        time = periods * bounds.period
        speed = float((np.maximum(moved / time, np.abs(sent.velocity)) / bounds.joints.speed).max())
        change = np.abs(sent.velocity - last.velocity) / time
        acceleration = float((change / bounds.acceleration).max())
        extremes = self.extremes
        extremes.speed = max(extremes.speed, speed)
        extremes.acceleration = max(extremes.acceleration, acceleration)
        if speed > 1.0 + SHARE:
            self._note("joint speed: set-point", moment, f"{speed:.4f} of the limit")
        if acceleration > 1.0 + SHARE:
            self._note("joint acceleration: set-point", moment, f"{acceleration:.4f} of the limit")
        place = self.trocar_pose(sent.position)
        extremes.planned_rcm = max(extremes.planned_rcm, place.rcm_error)
        if not place.rcm_error <= bounds.rcm:
            self._note("RCM: set-point", moment, f"{place.rcm_error * 1e3:.3f} mm off")

    def _follow_stop(self, moment: CheckedTick) -> None:
        is_still = moment.after.mode.state not in IN_MOTION
        if moment.was_stopped and self._stopped is None:
            self._stopped = self.ticks
        if self._stopped is None:
            return
        took = (self.ticks - self._stopped) * self.bounds.period
        if is_still:
            self.extremes.stop = max(self.extremes.stop, took)
            self._stopped = None
        elif took > self.bounds.stop:
            words = f"{took:.3f} s, allowed {self.bounds.stop:.3f} s"
            self._note("stop: it takes too long", moment, words)
            self._stopped = None

    def _check_robot(self, moment: CheckedTick) -> None:
        bounds, place = self.bounds, self._placed(moment.position)
        self.extremes.rcm = max(self.extremes.rcm, place.rcm_error)
        self.extremes.tension = max(self.extremes.tension, moment.tension)
        if not place.rcm_error <= bounds.rcm:
            self._note("RCM: true shaft", moment, f"{place.rcm_error * 1e3:.3f} mm off")
        if not moment.tension <= bounds.tension:
            words = f"{moment.tension:.3f} N, allowed {bounds.tension:.3f} N"
            self._note("tension: true", moment, words)
        speed = float((np.abs(moment.velocity) / bounds.joints.speed).max())
        if speed > 1.0 + 1e-3:
            self._note("joint speed: true", moment, f"{speed:.4f} of the limit")
        self._check_rest(moment)

    def _placed(self, position: Array) -> TrocarPose:
        """Where the tool truly is towards the trocar, measured anew where joints have moved."""
        if self._place is None or not np.array_equal(position, self._place[0]):
            self._place = position, self.trocar_pose(position)
        return self._place[1]

    def _check_rest(self, moment: CheckedTick) -> None:
        """At rest the joints come to stand once the servo has played what was sent."""
        if moment.after.mode.state in IN_MOTION or moment.is_servo_braking:
            self._rested = moment.now
            return
        if moment.now - self._rested <= SETTLED:
            return
        fastest = float(np.abs(moment.velocity).max())
        if fastest > (allowed := self.bounds.resting):
            words = f"{fastest:.4f} rad/s in {moment.after.mode.state.value}, allowed {allowed:g}"
            self._note("mode: joints move at rest", moment, words)


def _words(mode: ControllerMode) -> str:
    then = f" to {mode.mode_after.value}" if mode.state is State.STOPPING else ""
    return f"{mode.state.value}{then}"
