# SPDX-License-Identifier: BSD-3-Clause
"""What other threads ask of the executor, until its next tick takes it."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

from rst_control.execution.orders import Order
from rst_control.execution.snapshot import Change
from rst_control.types import Cause

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

    def take_stops(self) -> Iterator[tuple[Cause, float | None, str]]:
        """All stops."""
        while self.stops:
            yield self.stops.popleft()

    def take_orders(self) -> Iterator[Order]:
        """As many orders as a tick has time for."""
        for _ in range(min(ORDERS_PER_TICK, len(self.orders))):
            yield self.orders.popleft()
