# SPDX-License-Identifier: BSD-3-Clause
"""Whether the robot's measurements can be true: joints that jump, freeze or contradict themselves.

Fresh stamps say that somebody still sends, not that somebody still measures. Compared
here are the numbers with each other, with the time between them and with what was commanded.
"""

from __future__ import annotations

import numpy as np

from rst_control.config import ControllerConfig, LimitsConfig
from rst_control.kinematics.configuration import planning_joints, robot_joints
from rst_control.supervision.tension_plausibility import TensionPlausibility
from rst_control.types import JOINT_COUNT, JOINTS, Measurement, Vector

GAP = 10.5  # periods without measurements, over which velocities no longer give the way
MEMORY = 0.5  # [s] over which what velocities add up to is compared with the way of the positions


class SensorWatch:
    """Looks at each new measurement; `objection` names what cannot be true.

    An objection stays until the sensors have been plausible for `plausible_for`; a frozen joint's
    until its reading changes. It is a latch of the controller that keeps the robot from going on.

    Args:
        settings: Of the controller.
        speed: Greatest speed of each joint [rad/s]. Shape (10,).
    """

    def __init__(self, settings: ControllerConfig, speed: Vector) -> None:
        self._config = settings.watchdogs.sensors
        self._period = 1.0 / settings.rate
        self._longest = settings.watchdogs.joint_state_age  # [s] by which messages may be late
        self._gap = max(GAP / settings.rate, self._longest)  # real robots measure less often
        after = self._config.frozen_after + self._longest + settings.tension.delay
        self._joints = FrozenJoints(self._config.frozen_way, after)
        self._tension = TensionPlausibility(self._config, after)
        self._speed = np.array(speed, dtype=float)
        self._last: Measurement | None = None
        self._drift = np.zeros(JOINT_COUNT)  # [rad] of the positions away from their velocities
        self._fast = np.zeros(JOINT_COUNT)  # [rad/s] reached lately
        self._words, self._until = "", -np.inf
        self._tension_words = ""

    @property
    def objection(self) -> str:
        """Why the measurements are not believed; empty: they are."""
        return self._joints.objection or self._words

    @property
    def tension_objection(self) -> str:
        """What the newest measurement shows against the tension; empty: nothing."""
        return self._tension_words

    def update(self, measured: Measurement, setpoint: Vector | None, pulled: float | None) -> None:
        """Take in a new measurement.

        Args:
            measured: The newest; one that is no newer than the last is passed over.
            setpoint: Where the joints are sent [rad]; None: nowhere. Shape (10,).
            pulled: Place on the pull's path while it raises the tension [m]; None: it does not.
        """
        last = self._last
        if not measured.connected:
            self._forget()
            return
        if last is None:
            self._last = measured
            return
        if measured.stamp <= last.stamp:
            return
        self._last = measured
        if measured.fault:  # it pulls nothing
            pulled = None
        is_gap = measured.stamp - last.stamp > self._gap  # over it, all may have changed
        words = self._motion(last, measured, is_gap)
        is_blind = is_gap or bool(measured.tension_invalid_reason)
        self._tension_words = self._tension.update(last, measured, None if is_blind else pulled)
        words = words or self._tension_words
        self._joints.update(last, measured, kept_open(measured, setpoint))
        if words:
            self._words = self._words or words
            self._until = measured.stamp + self._config.plausible_for
        elif measured.stamp >= self._until:
            self._words = ""

    def _forget(self) -> None:
        """The robot was lost: when it comes back, it may be anywhere."""
        self._last, self._words, self._until = None, "", -np.inf
        self._drift[:], self._fast[:] = 0.0, 0.0
        self._joints.forget()
        self._tension.forget()

    def _motion(self, last: Measurement, measured: Measurement, is_gap: bool) -> str:
        moved, span = measured.position - last.position, self._span(last, measured)
        within = max(span, self._period)  # stamps may jitter
        most = self._speed * (within + self._config.late)
        excess = np.abs(moved) - most
        joint = int(excess.argmax())
        if excess[joint] > self._config.jump:
            self._drift[:] = 0.0
            return (
                f"{JOINTS[joint]} jumped by {moved[joint]:+.4f} rad in {within * 1e3:.1f} ms, "
                f"allowed {most[joint] + self._config.jump:.4f}"
            )
        if is_gap:
            self._drift[:], self._fast[:] = 0.0, 0.0
            return ""
        return self._contradiction(last, measured, moved, span)

    def _span(self, last: Measurement, measured: Measurement) -> float:
        """Time between two measurements [s].

        By the robot's own stamps where it gives them, since messages come bunched. What the times
        of arrival cannot explain is a clock that was set meanwhile: then these count.
        It may be less than a period: of a robot that reports more often, the newest is taken.
        """
        arrived = measured.stamp - last.stamp
        if measured.sent is None or last.sent is None:
            return arrived
        sent = measured.sent - last.sent
        return sent if 0.0 <= sent <= arrived + self._longest else arrived

    def _contradiction(
        self, last: Measurement, measured: Measurement, moved: Vector, span: float
    ) -> str:
        """Whether the velocities add up to the way; forgotten over time, for neither is exact."""
        kept = np.exp(-span / MEMORY)
        speed = np.maximum(np.abs(last.velocity), np.abs(measured.velocity))
        self._fast = np.maximum(kept * self._fast, speed)
        self._drift = kept * self._drift + moved - 0.5 * span * (last.velocity + measured.velocity)
        allowed = self._config.velocity_error + self._config.velocity_lag * self._fast
        excess = np.abs(self._drift) - allowed
        joint = int(excess.argmax())
        if excess[joint] <= 0.0:
            return ""
        return (
            f"{JOINTS[joint]} positions went {self._drift[joint]:+.4f} rad away from its "
            f"velocities, {measured.velocity[joint]:+.3f} rad/s now, allowed {allowed[joint]:.4f}"
        )


def kept_open(measured: Measurement, setpoint: Vector | None) -> Vector | None:
    """The set-point with the jaws sent no further closed than they stand [rad]. Shape (10,).

    What lies between them may keep them open; that is a grip, and no frozen reading. None: nowhere,
    as of a robot with a fault, wherever it is sent.
    """
    if setpoint is None or measured.fault:
        return None
    q, sent = planning_joints(setpoint)
    return robot_joints(q, max(sent, planning_joints(measured.position)[1]))


def max_joint_speed(config: LimitsConfig) -> Vector:
    """What no joint can pass, whichever layer of limits is active [rad/s]. Shape (10,)."""
    layers = [[*layer.arm_velocity, *[layer.tool_velocity] * 3] for layer in config.layers]
    greatest: Vector = np.array(layers).max(axis=0)
    return greatest


class FrozenJoints:
    """Finds joints whose reading stays the same to the last bit while they are sent elsewhere.

    At rest the reading of a coarse encoder may stay as it is for ever, and a joint sets off a while
    after its set-point. So it counts only once the set-point is away by more than a step of any
    encoder, and has been for a while.

    Args:
        way: That a set-point moves without its reading [rad].
        after: How long it has been that far [s].
    """

    def __init__(self, way: float, after: float) -> None:
        self._way, self._after = way, after
        self._sent = np.full(JOINT_COUNT, np.nan)  # [rad] set-point when the reading last changed
        self._since = np.full(JOINT_COUNT, np.inf)  # [s] when the set-point had gone far from there
        self._stuck: tuple[int, float] | None = None  # joint and reading [rad]
        self.objection = ""

    def update(self, last: Measurement, measured: Measurement, setpoint: Vector | None) -> None:
        """Take in a new measurement, and where the joints are sent [rad], shape (10,)."""
        position = measured.position
        if self._stuck is not None and position[self._stuck[0]] != self._stuck[1]:
            self._stuck, self.objection = None, ""
        if setpoint is None:
            self._restart()
            return
        anew = (position != last.position) | np.isnan(self._sent)
        self._sent = np.where(anew, setpoint, self._sent)
        away = np.abs(setpoint - self._sent)
        self._since = np.where(away > self._way, np.minimum(self._since, measured.stamp), np.inf)
        joint = int(self._since.argmin())
        if measured.stamp - self._since[joint] >= self._after and self._stuck is None:
            self._stuck = joint, float(position[joint])
            self.objection = (
                f"{JOINTS[joint]} frozen or blocked: it reads {position[joint]:.6f} rad without "
                f"any change while its set-point moved by {away[joint]:.4f}, "
                f"allowed {self._way:.4f}"
            )

    def forget(self) -> None:
        """Begin anew."""
        self._restart()
        self._stuck, self.objection = None, ""

    def _restart(self) -> None:
        self._sent[:], self._since[:] = np.nan, np.inf
