# SPDX-License-Identifier: BSD-3-Clause
"""What makes the controller brake and latch: pure checks of what was measured and commanded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rst_control.config import WatchdogConfig
from rst_control.motion import Motion
from rst_control.patient import Placement
from rst_control.sensors import SensorWatch
from rst_control.types import JOINT_COUNT, JOINTS, Measurement, Reason, Rejected, Vector


@dataclass(frozen=True)
class WatchdogLimits:
    """Settings of the watchdogs, gathered from their files."""

    settings: WatchdogConfig
    rcm_error: float  # [m]
    tension: float  # [N]


@dataclass(frozen=True, eq=False, slots=True)
class Watched:
    """What a motion shows to the watchdogs in one tick."""

    setpoint: Vector  # (10,), [rad] last commanded
    placement: Placement  # of the measured joints
    raises_tension: bool  # the present phase may pull
    needs_grip: bool  # the present phase pulls on tissue
    overtime: float  # [s] that the phase takes longer than its way at its speed
    heartbeat_age: float | None  # [s] of the voice node; None: the command was not spoken

    @classmethod
    def of(
        cls,
        motion: Motion,
        setpoint: Vector | None,
        placement: Placement,
        now: float,
        silent: float | None,
    ) -> Watched:
        """What a motion shows at a time [s]; `silent` is the age of the heartbeat [s]."""
        return cls(
            setpoint=np.zeros(JOINT_COUNT) if setpoint is None else setpoint,
            placement=placement,
            raises_tension=motion.raises_tension,
            needs_grip=motion.needs_grip,
            overtime=motion.overtime(now),
            heartbeat_age=silent,
        )


class Watchdogs:
    """Names the first thing that is wrong; an empty string means that nothing is.

    Args:
        limits: Settings.
        sensors: Whether measurements can be true.
    """

    def __init__(self, limits: WatchdogLimits, sensors: SensorWatch) -> None:
        self._limits, self._sensors = limits, sensors
        self._settings = limits.settings

    def look(self, measured: Measurement, setpoint: Vector | None, pulled: float | None) -> None:
        """Take in a new measurement; see `SensorWatch.look`."""
        self._sensors.look(measured, setpoint, pulled)

    def robot(self, now: float, measured: Measurement | None) -> Rejected | None:
        """Whether the robot is there and speaks, at rest as in motion."""
        if measured is None or not measured.connected:
            return Rejected(Reason.NOT_CONNECTED, "robot not connected")
        age, allowed = now - measured.stamp, self._settings.joint_state_age
        if age > allowed:
            words = f"joint states stale, {age * 1e3:.0f} ms old, allowed {allowed * 1e3:.0f} ms"
            return Rejected(Reason.STALE, f"{words}: {measured.fault}" if measured.fault else words)
        if measured.fault:
            return Rejected(Reason.FAULTED, f"robot fault: {measured.fault}")
        if self._sensors.objection:
            return Rejected(Reason.FAULTED, f"sensor fault: {self._sensors.objection}")
        return None

    def following(self, measured: Measurement, setpoint: Vector) -> str:
        """Whether every joint is where it was sent."""
        error = np.abs(measured.position - setpoint)
        joint = int(error.argmax())
        if error[joint] <= self._settings.following_error:
            return ""
        return (
            f"{JOINTS[joint]} {error[joint]:.3f} rad off its set-point, "
            f"allowed {self._settings.following_error:.3f}"
        )

    def is_at_rest(self, measured: Measurement) -> bool:
        """Whether every joint is measured at rest."""
        return bool(np.abs(measured.velocity).max() <= self._settings.at_rest_speed)

    def waking(self, now: float, measured: Measurement | None, is_led: bool) -> Rejected | None:
        """Why the robot is not fit for "hey robot"; while it is led in a motion it may move."""
        lost = self.robot(now, measured)
        if lost is not None or measured is None or is_led or self.is_at_rest(measured):
            return lost
        return Rejected(Reason.NOT_AT_REST, "robot not at rest yet; say it again")

    def motion(self, now: float, measured: Measurement | None, watched: Watched) -> str:
        """Whether a motion may go on."""
        lost = self.robot(now, measured)
        if lost is not None or measured is None:
            return lost.words if lost else ""
        return (
            self.following(measured, watched.setpoint)
            or self._rcm(watched.placement)
            or self._tension(measured, watched)
            or self._grip(measured, watched)
            or self._times(watched)
        )

    def _rcm(self, place: Placement) -> str:
        """In force unless the whole robot is measured outside the patient; no number: it fires."""
        allowed = self._limits.rcm_error
        if place.is_outside or place.error <= allowed:
            return ""
        words = f"shaft {place.error * 1e3:.2f} mm off the trocar, allowed {allowed * 1e3:.2f} mm"
        height = f"{place.height * 1e3:.1f} mm above the patient's surface"
        return f"{words} with the robot {height}" if place.height > 0.0 else words

    def _tension(self, measured: Measurement, watched: Watched) -> str:
        allowed = self._limits.tension
        if not watched.raises_tension or measured.tension <= allowed:
            return ""
        return f"tension {measured.tension:.2f} N, allowed {allowed:.2f} N"

    def _grip(self, measured: Measurement, watched: Watched) -> str:
        return "tissue slipped from the jaws" if watched.needs_grip and not measured.gripped else ""

    def _times(self, watched: Watched) -> str:
        age, allowed = watched.heartbeat_age, self._settings.voice_heartbeat_age
        if age is not None and age > allowed:
            return f"voice node silent for {age:.1f} s, allowed {allowed:.1f} s"
        if watched.overtime > self._settings.phase_timeout:
            return f"phase took {self._settings.phase_timeout:.0f} s longer than planned"
        return ""
