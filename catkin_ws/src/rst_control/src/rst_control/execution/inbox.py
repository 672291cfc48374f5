# SPDX-License-Identifier: BSD-3-Clause
"""What other threads ask of the executor, until its next tick takes it."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

from rst_control.commands.spec import Role
from rst_control.execution.orders import OUTRUN, Order
from rst_control.execution.snapshot import Change
from rst_control.types import Cause, Reason, Rejected

ORDERS_PER_TICK = 4  # however many callers there are, a tick stays short


class Inbox:
    """Stops, changes and orders; each is put in by any thread and taken by one.

    Attributes:
        orders: Verified commands.
        stops: Cause, when it was received [s] (None: not known), and who asked for it.
        changes: Of what verification relies on.
    """

    def __init__(self) -> None:
        self.orders: deque[Order] = deque()
        self.stops: deque[tuple[Cause, float | None, str]] = deque()
        self.changes: deque[Change] = deque()
        self._older = 0  # orders still waiting that came before the last stop

    def take_stops(self) -> Iterator[tuple[Cause, float | None, str]]:
        """All stops."""
        while self.stops:
            stop = self.stops.popleft()
            self._older = len(self.orders)
            yield stop

    def take_orders(self) -> Iterator[tuple[Order, Rejected | None]]:
        """As many orders as a tick has time for, each with why a stop outran it."""
        for _ in range(min(ORDERS_PER_TICK, len(self.orders))):
            order = self.orders.popleft()
            yield order, self._outrun(order)

    def _outrun(self, order: Order) -> Rejected | None:
        """A stop is not cleared by a "hey robot" that came before it."""
        is_older, self._older = self._older > 0, max(0, self._older - 1)
        if not is_older or order.command.role is not Role.ACTIVATE:
            return None
        return Rejected(Reason.HALTED, OUTRUN)
