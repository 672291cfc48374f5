# SPDX-License-Identifier: BSD-3-Clause
"""An executor that carries nothing out, and notes what reaches it."""

from __future__ import annotations

from rst_control.types import Cause


class Nobody:
    """Stands behind a queue, in place of the executor."""

    def __init__(self) -> None:
        self.stops: list[str] = []
        self.orders: list[object] = []
        self.refusals: list[tuple[str, str]] = []

    def stop(self, cause: Cause, received: float | None = None, caller: str = "") -> None:
        """Note a stop."""
        self.stops.append(cause.words)

    def post(self, order: object) -> None:
        """Note an order that would be carried out."""
        self.orders.append(order)

    def note_refusal(self, command: str, cause: Cause, now: float, caller: str) -> None:
        """Note a refusal."""
        self.refusals.append((command, cause.words))
