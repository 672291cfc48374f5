# SPDX-License-Identifier: BSD-3-Clause
"""Takes the grasp point from a tracker by itself: steady, near, at rest and with empty jaws."""

from __future__ import annotations

from concurrent.futures import Future
from dataclasses import dataclass
from typing import Final

import numpy as np

from rst_control.config.tracking import TrackingConfig
from rst_control.execution.orders import Reply
from rst_control.registration.grasp_point import GraspPointRegistrar
from rst_control.registration.registrar import ready
from rst_control.registration.tracked_place import Report, SteadyPlace, is_other_way
from rst_control.registration.trocar_context import ActiveTrocarContext
from rst_control.types import Cause, Reason

PASSING: Final = (Reason.STALE, Reason.NOT_AT_REST)  # they end, and no situation changes by that


@dataclass(frozen=True, eq=False)
class Asked:
    """A tracked point that was asked for."""

    report: Report
    serial: int  # of the situation in which it was asked for
    reply: Future[Reply]

    @property
    def refusal(self) -> Cause | None:
        """Why it was refused; None: it was not, or is not yet."""
        if not self.reply.done() or self.reply.cancelled():
            return None
        answer = self.reply.result()
        return Cause(answer.reason, answer.message) if answer.reason is not None else None

    def holds(self, serial: int) -> bool:
        """Whether it need not be asked for again in a situation.

        A refusal holds while nothing changes, unless it passes by itself. A point that was set
        holds: if another one counts since, a person set it.
        """
        refusal = self.refusal
        if self.reply.cancelled():
            return False
        return refusal is None or (serial == self.serial and refusal.reason not in PASSING)


class TrackedGrasp:
    """Follows what a tracker reports; `step` sets what may be set.

    Args:
        config: What is believed, and whether it is taken.
        present: The active grasp point, and the configured one, from which the range counts.
        registrar: Sets another.
    """

    def __init__(
        self,
        config: TrackingConfig,
        present: ActiveTrocarContext,
        registrar: GraspPointRegistrar,
    ) -> None:
        self._config, self._present, self._registrar = config.grasp_point, present, registrar
        home = np.array(present.configured.grasp_point)
        self._place = SteadyPlace(config.grasp_point, config.age, home)
        self._asked: Asked | None = None  # the newest

    def update(self, report: Report) -> None:
        """Take in a report."""
        self._place.update(report)

    def objection(self, now: float) -> Cause | None:
        """Why the tracked point is not taken now; None: it is, or would be."""
        found, asked = self._place.taken(now), self._asked
        if isinstance(found, Cause):
            return found
        if asked is None or self._is_in_force(found, now):
            return None
        return asked.refusal if self._is_same(found, asked.report) else None

    def step(self, now: float, tracker: str) -> Future[Reply] | None:
        """Ask for the tracked point where it is another than the active one; None: nothing to do.

        Args:
            now: Time [s], steady clock.
            tracker: Name of the node that reported it.
        """
        found = self._place.taken(now) if self._config.is_taken else None
        if not isinstance(found, Report):
            return None
        view, asked = self._registrar.view(), self._asked
        if self._is_in_force(found, now):
            return None
        if asked is not None and self._is_same(found, asked.report) and asked.holds(view.serial):
            return None
        if isinstance(ready(self._present.current, view), Cause):
            return None
        reply = self._registrar.ask((*found.place.tolist(), *found.pull), tracker)
        self._asked = Asked(found, view.serial, reply)
        return reply

    def _is_in_force(self, found: Report, now: float) -> bool:
        scene = self._present.current.config.scene
        return self._is_same(found, Report(np.array(scene.grasp_point), now, scene.pull_direction))

    def _is_same(self, found: Report, other: Report) -> bool:
        is_near = float(np.linalg.norm(found.place - other.place)) < self._config.min_change
        return is_near and not is_other_way(found.pull, other.pull)
