# SPDX-License-Identifier: BSD-3-Clause
"""What makes the controller brake and latch: pure checks of what was measured and commanded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rst_control.config import WatchdogConfig
from rst_control.planning.patient_surface import TrocarPose
from rst_control.robot.health import robot_unfit
from rst_control.supervision.node_liveness import MASTER, NodeLiveness
from rst_control.supervision.plausibility import SensorWatch
from rst_control.tension.delay_bound import DelayBound
from rst_control.types import JOINTS, Cause, Measurement, Reason, Vector


@dataclass(frozen=True)
class WatchdogLimits:
    """Settings of the watchdogs, gathered from their files."""

    settings: WatchdogConfig
    rcm_error: float  # [m]
    tension: float  # [N]
    tension_delay: float = 0.0  # [s] by which the measured tension is late


@dataclass(frozen=True, eq=False, slots=True)
class MonitoredMotion:
    """What a motion shows to the watchdogs in one tick."""

    setpoint: Vector  # (10,), [rad] last commanded
    trocar_pose: TrocarPose  # of the measured joints
    raises_tension: bool  # the present phase may pull
    needs_grip: bool  # the present phase pulls on tissue
    overtime: float  # [s] that the phase takes longer than its way at its speed
    heartbeat_age: float | None  # [s] of the voice node; None: the command was not spoken
    owner: str = ""  # node that asked for it and has to stay; empty: none has
    only_opens: bool = False  # the jaws open while the arm stands still
    easing_since: float | None = None  # [s] start of the phase of a command that eases the load


class Watchdogs:
    """Names the first thing that is wrong; None means that nothing is.

    Args:
        limits: Settings.
        sensors: Whether measurements can be true.
        liveness: Whether those are there without whom nothing may move.
    """

    def __init__(
        self, limits: WatchdogLimits, sensors: SensorWatch, liveness: NodeLiveness
    ) -> None:
        self._limits, self._sensors, self._liveness = limits, sensors, liveness
        self._settings = limits.settings
        self._delay_bound = DelayBound(limits.tension_delay)
        self._easing_since: float | None = None  # [s] of the easing phase watched last
        self._empty = 0.0  # [N] that empty jaws read then, if it was not to be trusted

    def update(self, measured: Measurement, setpoint: Vector | None, pulled: float | None) -> None:
        """Take in a new measurement; see `SensorWatch.update`."""
        self._sensors.update(measured, setpoint, pulled)
        if measured.tension_invalid_reason:
            self._delay_bound.forget()
        else:
            self._delay_bound.update(measured.stamp, measured.tension)

    @property
    def tension_objection(self) -> str:
        """What the newest measurement shows against the tension; empty: nothing."""
        return self._sensors.tension_objection

    def master(self) -> Cause | None:
        """Whether the ROS master is there; a robot at rest keeps its set-point without it."""
        gone = self._liveness.of(MASTER)
        words = f"the ROS master {gone}: nobody new could stop the robot"
        return Cause(Reason.NO_MASTER, words) if gone else None

    def lost(self, now: float, measured: Measurement | None) -> Cause | None:
        """Whether all are there without whom nothing may begin or go on: master and robot."""
        return self.master() or self.robot(now, measured)

    def robot(self, now: float, measured: Measurement | None) -> Cause | None:
        """Whether the robot is there and speaks, at rest as in motion."""
        unfit = robot_unfit(measured, now, self._settings.joint_state_age)
        if unfit is None and self._sensors.objection:
            return Cause(Reason.SENSOR_FAULT, f"sensor fault: {self._sensors.objection}")
        return unfit

    def owner(self, name: str) -> Cause | None:
        """Whether the node that asked for a motion is still there; it need not, without a name."""
        gone = self._liveness.of(name) if name else ""
        return Cause(Reason.NODE_LOST, f"{name} {gone}") if gone else None

    def following(self, measured: Measurement, setpoint: Vector) -> Cause | None:
        """Whether every joint is where it was sent."""
        error = np.abs(measured.position - setpoint)
        joint = int(error.argmax())
        if error[joint] <= self._settings.following_error:
            return None
        words = (
            f"{JOINTS[joint]} {error[joint]:.3f} rad off its set-point, "
            f"allowed {self._settings.following_error:.3f}"
        )
        return Cause(Reason.OFF_SETPOINT, words)

    def is_at_rest(self, measured: Measurement) -> bool:
        """Whether every joint is measured at rest."""
        return bool(np.abs(measured.velocity).max() <= self._settings.at_rest_speed)

    def activation(self, now: float, measured: Measurement | None, is_led: bool) -> Cause | None:
        """Why the robot is not fit for "hey robot"; while it is led in a motion it may move."""
        lost = self.lost(now, measured)
        if lost is not None or measured is None or is_led or self.is_at_rest(measured):
            return lost
        return Cause(Reason.NOT_AT_REST, "robot not at rest yet; say it again")

    def motion(
        self, now: float, measured: Measurement | None, watched: MonitoredMotion
    ) -> Cause | None:
        """Whether a motion may go on."""
        lost = self.lost(now, measured)
        if lost is not None or measured is None:
            return lost
        return (
            self.following(measured, watched.setpoint)
            or (None if watched.only_opens else self._rcm(watched.trocar_pose))
            or self._tension(measured, watched)
            or self._grip(measured, watched)
            or self._times(watched)
        )

    def _rcm(self, place: TrocarPose) -> Cause | None:
        """In force unless the whole robot is measured outside the patient; no number: it fires."""
        allowed = self._limits.rcm_error
        if place.is_outside or place.error <= allowed:
            return None
        words = f"shaft {place.error * 1e3:.2f} mm off the trocar, allowed {allowed * 1e3:.2f} mm"
        height = f"{place.height * 1e3:.1f} mm above the patient's surface"
        words = f"{words} with the robot {height}" if place.height > 0.0 else words
        return Cause(Reason.OFF_TROCAR, words)

    def _tension(self, measured: Measurement, watched: MonitoredMotion) -> Cause | None:
        allowed = self._limits.tension + self._read_by_empty_jaws(measured, watched.easing_since)
        ahead = self._delay_bound.ahead
        if not watched.raises_tension or measured.tension + ahead <= allowed:
            return None
        late = f" and {ahead:.2f} N more since it was measured" if ahead >= 0.01 else ""
        words = f"tension {measured.tension:.2f} N{late}, allowed {allowed:.2f} N"
        return Cause(Reason.OVER_TENSION, words)

    def _read_by_empty_jaws(self, measured: Measurement, easing_since: float | None) -> float:
        """What a tension that is not trusted read when empty jaws began to leave: no load [N].

        A sensor that is stuck there would else keep the tool in the patient.
        """
        if easing_since != self._easing_since:
            self._easing_since = easing_since
            is_empty = easing_since is not None and not measured.gripped
            is_untrue = is_empty and bool(measured.tension_invalid_reason)
            self._empty = max(0.0, measured.tension) if is_untrue else 0.0
        return self._empty

    def _grip(self, measured: Measurement, watched: MonitoredMotion) -> Cause | None:
        has_slipped = watched.needs_grip and not measured.gripped
        return Cause(Reason.SLIPPED, "tissue slipped from the jaws") if has_slipped else None

    def _times(self, watched: MonitoredMotion) -> Cause | None:
        if gone := self.owner(watched.owner):
            return Cause(gone.reason, f"{gone.words} during its motion")
        age, allowed = watched.heartbeat_age, self._settings.voice_heartbeat_age
        if age is not None and age > allowed:
            words = f"voice node silent for {age:.1f} s, allowed {allowed:.1f} s"
            return Cause(Reason.VOICE_SILENT, words)
        if watched.overtime > self._settings.phase_timeout:
            limit = self._settings.phase_timeout
            words = f"phase took {watched.overtime:.1f} s longer than planned, allowed {limit:g} s"
            return Cause(Reason.OVERTIME, words)
        return None
