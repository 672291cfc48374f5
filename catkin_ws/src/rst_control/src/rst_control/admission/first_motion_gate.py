# SPDX-License-Identifier: BSD-3-Clause
"""Shows the first motion and asks before it, so that a person has seen the path before it is taken.

Until a person has confirmed, every command that would move the robot is planned, verified and
shown, and then refused. The confirmation is for the command that was shown last, from the place
where it was shown, towards the same trocar and grasp point, and for a while. Once that motion has
set off, nothing asks any more, and the next command hides the path.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from rst_control.admission.command_queue import Verify
from rst_control.commands.request import Accepted, Plan, Request, Situation
from rst_control.execution.orders import Reply
from rst_control.types import Reason, Rejected, Vector

VALID_FOR: Final = 60.0  # [s] that a confirmation holds
SAME_PLACE: Final = 5e-3  # [rad] that joints may have moved since the path was shown
ASK: Final = (
    'dry run: "{command}" {words}; its path is shown on rst_control/preview. Look at it, call '
    'rst_control/confirm, then say "{command}" again'
)
NOTHING: Final = 'nothing to confirm: no path was shown yet; give the command first, as "tense"'
ALREADY: Final = "nothing to confirm: the first motion was confirmed before"


class FirstMotion:
    """Verification that asks before the first motion; confirmed from any thread.

    Args:
        verify: Decides everything else.
        show: Shows a plan, or with None no more.
        clock: Time [s].
        context: What plans refer to; another object where trocar or grasp point is another.
    """

    def __init__(
        self,
        verify: Verify,
        show: Callable[[Plan | None], None],
        clock: Callable[[], float],
        context: Callable[[], object],
    ) -> None:
        self._verify, self._show, self._clock, self._context = verify, show, clock, context
        self._shown: tuple[Plan, Vector, object] | None = None  # joints where it begins, context
        self._confirmed: float | None = None  # [s] when
        self._is_free = False

    def __call__(self, request: Request, situation: Situation) -> Accepted | Rejected:
        """Decide; see the module."""
        context, decision = self._context(), self._verify(request, situation)
        measured = situation.measurement
        if self._is_free and self._shown is not None:
            self._shown = None
            self._show(None)
        if self._is_free or isinstance(decision, Rejected) or measured is None:
            return decision
        plan = decision.plan
        if not plan.phases:
            return decision
        if self._is_confirmed(plan, measured.position, context):
            return replace(decision, started=self._set_free)
        self._shown, self._confirmed = (plan, measured.position, context), None
        self._show(plan)
        words = ASK.format(command=plan.command_words, words=plan.words)
        return Rejected(Reason.NOT_CONFIRMED, words)

    def confirm(self) -> Reply:
        """Let the motion shown last set off when it is asked for again."""
        if self._is_free:
            return Reply(False, ALREADY, Reason.NOT_CONFIRMED)
        if self._shown is None:
            return Reply(False, NOTHING, Reason.NOT_CONFIRMED)
        self._confirmed = self._clock()
        command = self._shown[0].command_words
        return Reply(True, f'confirmed: say "{command}" again within {VALID_FOR:.0f} s')

    def _set_free(self) -> None:
        """From the control loop: only now is it sure that what was shown is carried out."""
        self._is_free = True

    def _is_confirmed(self, plan: Plan, place: Vector, context: object) -> bool:
        if self._shown is None or self._confirmed is None:
            return False
        shown, where, referred_to = self._shown
        is_same = shown.command_words == plan.command_words and referred_to is context
        is_near = float(np.abs(place - where).max()) <= SAME_PLACE
        return is_same and is_near and self._clock() - self._confirmed <= VALID_FOR
