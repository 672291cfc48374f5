# SPDX-License-Identifier: BSD-3-Clause
"""The robot as it was last measured: what is known against that, and where its tool is."""

from __future__ import annotations

from collections.abc import Callable

from rst_control.execution.setpoint import SetpointState
from rst_control.planning.patient_surface import NOWHERE, TrocarPose
from rst_control.supervision.tension_trust import TensionTrust
from rst_control.supervision.watchdogs import Watchdogs
from rst_control.types import Cause, Measurement, Vector


class MeasuredRobot:
    """Taken anew at each tick.

    Args:
        watchdogs: What is plausible.
        trocar_pose: Where the tool is towards the trocar, for joint positions of shape (10,).
        tension_trust: Whether the tension is relied on.

    Attributes:
        measurement: The newest, with what is known against it; None: there was none.
        health: Why no motion may begin; None: the robot is there.
        trocar_pose: Of the newest.
        max_rcm_error: Largest measured in the present motion [m].
    """

    def __init__(
        self,
        watchdogs: Watchdogs,
        trocar_pose: Callable[[Vector], TrocarPose],
        tension_trust: TensionTrust,
    ) -> None:
        self._watchdogs, self.trocar_pose_of, self._trust = watchdogs, trocar_pose, tension_trust
        self._taken: Measurement | None = None  # the newest as it came
        self.measurement: Measurement | None = None
        self.health: Cause | None = None
        self.trocar_pose, self.max_rcm_error = NOWHERE, 0.0

    @property
    def tension(self) -> float:
        """Of the newest measurement [N]; 0: there was none."""
        return self.measurement.tension if self.measurement else 0.0

    def pulled(self, held: Vector | None) -> float | None:
        """How far the tissue is pulled at a set-point [m]: `TensionTrust.pulled`."""
        return self._trust.pulled(held)

    def update(self, now: float, measured: Measurement | None, state: SetpointState) -> None:
        """Take the newest measurement, and judge it by the set-point."""
        if measured is not None and measured is not self._taken:
            self._taken = measured
            self.measurement = measured = self._judge(measured, state)
            self.locate()
            if state.motion is not None:
                self.max_rcm_error = max(self.max_rcm_error, self.trocar_pose.rcm_error)
        self.health = self._watchdogs.lost(now, measured)

    def locate(self) -> None:
        """Find the tool anew, as the trocar may be another."""
        if self.measurement is not None:
            self.trocar_pose = self.trocar_pose_of(self.measurement.position)

    def synchronise(self, state: SetpointState) -> None:
        """Take over where the joints are: as the robot's side says, unless they are elsewhere."""
        measured = self.measurement
        if measured is not None:
            sent_to = measured.sent_to
            is_there = sent_to is not None and not self._watchdogs.following(measured, sent_to)
            state.synchronise(measured, sent_to if is_there else None)

    def synchronise_if_elsewhere(self, state: SetpointState) -> None:
        """The same, where nothing leads the joints and they are not at their set-point."""
        measured, held = self.measurement, state.held
        if measured is None or state.motion is not None:
            return
        if held is None or self._watchdogs.following(measured, held) is not None:
            self.synchronise(state)

    def _judge(self, measured: Measurement, state: SetpointState) -> Measurement:
        """Say what is known against it."""
        measured = self._trust.judge(measured, state.held)
        self._watchdogs.update(measured, state.held, state.pulled)
        if words := self._watchdogs.tension_objection:
            self._trust.distrust(words)
        return measured
