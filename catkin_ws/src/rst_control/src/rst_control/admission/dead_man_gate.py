# SPDX-License-Identifier: BSD-3-Clause
"""Whether the dead-man is held, where there is one: without it nothing may begin to move or go on.

A dead-man that falls silent counts as released: whoever speaks for it may hang or be gone.
"""

from __future__ import annotations

from collections.abc import Callable

from rst_control.admission.command_queue import Verify
from rst_control.commands.request import Accepted, Request, Situation
from rst_control.commands.spec import Role
from rst_control.types import Cause, Reason, Rejected


class DeadMan:
    """What is known of it. There is one from its first word on.

    Args:
        allowed: How long it may be silent before it counts as released [s].
        clock: Steady time [s].
    """

    def __init__(self, allowed: float, clock: Callable[[], float]) -> None:
        self._allowed, self._clock = allowed, clock
        self._heard: tuple[bool, float] | None = None  # whether it was held, and when [s]

    def note(self, is_held: bool) -> None:
        """Take its word; from any thread."""
        self._heard = (is_held, self._clock())

    @property
    def objection(self) -> Cause | None:
        """Why nothing may move; None: it is held, or there is none."""
        if self._heard is None:
            return None
        is_held, at = self._heard
        age = self._clock() - at
        if age > self._allowed:
            words = f"the dead-man is silent for {age:.1f} s, allowed {self._allowed:.1f} s"
            return Cause(Reason.DEAD_MAN, words)
        return None if is_held else Cause(Reason.DEAD_MAN, "the dead-man is not pressed")


class HeldOnly:
    """Verification that also asks for the dead-man, after all that lies nearer.

    Args:
        verify: Decides everything else.
        dead_man: Is asked for motions.
    """

    def __init__(self, verify: Verify, dead_man: DeadMan) -> None:
        self._verify, self._dead_man = verify, dead_man

    def __call__(self, request: Request, situation: Situation) -> Accepted | Rejected:
        """Decide."""
        decision = self._verify(request, situation)
        objection = self._dead_man.objection
        if isinstance(decision, Rejected) or objection is None:
            return decision
        is_motion = request.command.role is Role.MOTION
        return Rejected.by(objection) if is_motion else decision
