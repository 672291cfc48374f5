# SPDX-License-Identifier: BSD-3-Clause
"""A "hey robot" on its way: the robot gets a moment to clear a fault of its own."""

from __future__ import annotations

from collections.abc import Callable

from rst_control.execution.orders import Order
from rst_control.types import ROBOT_FAULTS, Cause, Reason

RESET_TIME = 0.3  # [s] that the robot gets to clear its own fault after "hey robot"


class FaultReset:
    """Keeps at most one "hey robot" until the robot is fit for it, or too much time has passed.

    Args:
        objection: Why the robot is not fit for it now; None: it is.
        clear_fault: Asks the robot to take set-points again.
        refuse: Answers an order that it will not be done.
    """

    def __init__(
        self,
        objection: Callable[[], Cause | None],
        clear_fault: Callable[[], None],
        refuse: Callable[[Order, Cause], None],
    ) -> None:
        self._objection, self._clear_fault, self._refuse = objection, clear_fault, refuse
        self._waiting: tuple[Order, float] | None = None  # and until when [s]

    def take(self, order: Order, now: float) -> Order | None:
        """Take one at a time [s]; gives it back where it is to be done at once."""
        refusal = self._objection()
        if refusal is None:
            return order
        if refusal.reason in ROBOT_FAULTS:  # which the robot may clear by itself
            self.drop(Cause(Reason.WITHDRAWN, "said again"))
            self._clear_fault()
            self._waiting = (order, now + RESET_TIME)
        else:
            self._refuse(order, refusal)
        return None

    def keep(self, now: float) -> Order | None:
        """The one that waits, once it is to be done; None: there is none, or it has to wait."""
        if self._waiting is None:
            return None
        order, until = self._waiting
        refusal = self._objection()
        if refusal is None:
            self._waiting = None
            return order
        if now >= until:
            self.drop(refusal)
        return None

    def drop(self, cause: Cause) -> None:
        """Refuse the one that waits, if there is one."""
        if self._waiting is not None:
            order, self._waiting = self._waiting[0], None
            self._refuse(order, cause)
