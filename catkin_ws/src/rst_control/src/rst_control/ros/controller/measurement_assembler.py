# SPDX-License-Identifier: BSD-3-Clause
"""What the controller believes of the robot's messages: their order, their age, their numbers.

Age is measured by the steady clock at arrival: a stamp from the future keeps nothing fresh.
Stamps of the robot have to advance: what is older than the last, or as old, counts as not having
come. Where the clock of both hosts is set, nothing happens. Where the robot's alone is set back,
joint states grow stale, the robot counts as lost, and then as back.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

import numpy as np

from rst_control.config import WatchdogConfig
from rst_control.ros.common.serialization import (
    BadMessage,
    JointStateReader,
    OutOfOrder,
    read_force,
)
from rst_control.types import JOINTS, Cause, Measurement, Reason, Vector, frozen_array

LOST_AFTER = 0.25  # [s] without joint states, at least: the robot counts as not connected
NO_EFFORT, NO_FORCE = np.zeros(len(JOINTS)), np.zeros(3)
INVALID_AT_START = {  # why the tension is not trusted, by its source, until the robot says more
    "sensor": "",
    "joint_torque": "nothing was heard yet of the estimate from joint torques",
    "none": "tension.source is none",
}


class Arrived(Protocol):
    """A message left as bytes, with the time at which it came."""

    raw: bytes
    arrived: float  # [s] steady clock
    ahead: float  # [s] wall clock less steady clock at that time


class MeasurementAssembler:
    """Makes measurements of messages. Callbacks set the newest; the loop's thread reads.

    Args:
        watchdogs: How old messages may be.
        clock: Steady, that of `Arrived.arrived` [s].
        tension: Where the tension comes from, as `tension.source` says.
    """

    def __init__(
        self, watchdogs: WatchdogConfig, clock: Callable[[], float], tension: str = "sensor"
    ) -> None:
        self.joints: Arrived | None = None
        self.wrench: Arrived | None = None
        self.gripped: bool | None = None  # None: not reported yet
        self.rest: Arrived | None = None  # where the robot holds the joints while nobody leads
        self.fault = ""
        self.tension_invalid_reason = INVALID_AT_START[tension]  # why the force is not relied on
        self._has_tension = tension != "none"
        self.out_of_order = 0  # joint states refused for their stamps since the start
        self._joint_age, self._clock = watchdogs.joint_state_age, clock
        self._tension_age = max(watchdogs.sensors.tension_age, watchdogs.joint_state_age)
        self._read = JointStateReader(JOINTS)
        self._seen: Arrived | None = None
        self._ahead = 0.0  # [s] of the last message
        self._read_rest = JointStateReader(JOINTS)
        self._rest_seen: Arrived | None = None
        self._sent_to: Vector | None = None
        self._refused, self._why_refused = 0, ""  # since the last joint states in order
        self._objection: Cause | None = None
        self._measured: Measurement | None = None

    @property
    def objection(self) -> str:
        """What is wrong with the robot's messages; empty: nothing."""
        count = self.out_of_order
        if self._objection is not None:
            return self._objection.words
        return f"{count} refused so far, out of order" if count else ""

    def measured(self) -> Measurement | None:
        """Newest joint states with the force on the jaws; None until the robot has reported all.

        Where jaws may be sent depends on whether they hold something: a controller that is started
        anew would open those that hold tissue, if it took the joints before the grip.
        """
        joints = self.joints
        if joints is not None and self.gripped is None:
            words = "the robot has not reported yet whether its jaws hold anything"
            self._objection = Cause(Reason.JOINT_MESSAGES, words)
        elif joints is not None and joints is not self._seen:
            self._seen = joints
            self._take(joints)
        else:
            self._keep()
        return self._measured

    def _take(self, joints: Arrived) -> None:
        is_set = joints.ahead != self._ahead  # this one may have been sent before that
        self._ahead = joints.ahead
        try:
            sample = self._read(joints.raw, joints.ahead)
        except OutOfOrder as error:
            self.out_of_order += 1
            self._refused, self._why_refused = self._refused + 1, str(error)
            self._keep()
            return
        except BadMessage as error:
            self._objection = Cause(Reason.JOINT_MESSAGES, str(error))
            self._keep()
            return
        if is_set:
            self._read.reset()
        self._objection, self._refused = None, 0
        self._take_rest()
        force = self._force(joints.arrived)
        self._measured = Measurement(
            position=sample.position,
            velocity=sample.velocity,
            effort=NO_EFFORT,
            stamp=joints.arrived,
            force=force,
            gripped=bool(self.gripped),
            fault=self._fault,
            tension_invalid_reason=self.tension_invalid_reason,
            sent=None if is_set else sample.stamp,
            sent_to=self._sent_to,
        )

    @property
    def _fault(self) -> str:
        """What the robot says of itself, else what is wrong with its messages; empty: nothing."""
        return self.fault or (self._objection.coded if self._objection else "")

    def led(self) -> None:
        """Note that a set-point was sent: where the robot held before it says nothing any more."""
        self._rest_seen, self._sent_to = self.rest, None

    def _take_rest(self) -> None:
        """Read where the robot holds the joints, if it has reported anew."""
        rest = self.rest
        if rest is None or rest is self._rest_seen:
            return
        self._rest_seen, self._sent_to = rest, None
        self._read_rest.reset()  # there may be one at each change, and none for hours
        try:
            self._sent_to = frozen_array(self._read_rest(rest.raw).position, len(JOINTS))
        except BadMessage as error:
            words = f"where the robot holds: {error}"
            self._objection = Cause(Reason.JOINT_MESSAGES, words)

    def _keep(self) -> None:
        """No new joint states: note what else has changed."""
        measured = self._measured
        if measured is None:
            return
        age = self._clock() - measured.stamp
        is_connected = age < max(LOST_AFTER, self._joint_age)
        if not is_connected:
            self._read.reset()  # a robot that comes back may have another clock
            self._sent_to = None  # and may hold elsewhere
        fault = self._fault
        if age > self._joint_age and self._refused and not fault:
            words = f"the last {self._refused} refused: {self._why_refused}"
            fault = Cause(Reason.JOINT_MESSAGES, words).coded
        if (is_connected, fault) != (measured.connected, measured.fault):
            self._measured = replace(measured, connected=is_connected, fault=fault)

    def _force(self, arrived: float) -> Vector:
        """Newest force on the jaws; where there is none, the last one, with an objection."""
        wrench = self.wrench
        if not self._has_tension:
            return NO_FORCE
        if wrench is None or arrived - wrench.arrived > self._tension_age:
            self._objection = Cause(Reason.TENSION_SENSOR, "tension is not measured")
        else:
            try:
                return read_force(wrench.raw)
            except BadMessage as error:
                self._objection = Cause(Reason.TENSION_SENSOR, str(error))
        return self._measured.force if self._measured is not None else np.zeros(3)
