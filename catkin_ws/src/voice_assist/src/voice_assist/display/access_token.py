# SPDX-License-Identifier: BSD-3-Clause
"""The token that a person reads off the terminal and enters once on the page."""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Callable

LETTERS = "ABCDEFGHJKMNPQRSTUVWXYZ23456789"  # without those that look alike
LENGTH = 8
FREE_TRIES = 5  # wrong ones before each costs a wait
WAIT = 2.0  # [s] after each further wrong one in which none is checked


class AccessToken:
    """Compares in constant time; guessing is slowed down.

    Args:
        clock: Steady clock [s].
        text: The token; None: a new one by chance.
    """

    def __init__(self, clock: Callable[[], float], text: str | None = None) -> None:
        self.text = text or "".join(secrets.choice(LETTERS) for _ in range(LENGTH))
        self._clock = clock
        self._wrong, self._not_before = 0, float("-inf")

    @property
    def is_locked(self) -> bool:
        """Whether no token is checked now, since too many were wrong."""
        return self._clock() < self._not_before

    def admits(self, given: str) -> bool:
        """Whether this is the token; small letters and spaces around it do not matter."""
        if self.is_locked:
            return False
        given = given.strip().upper()
        if hmac.compare_digest(given.encode("utf-8", "replace"), self.text.encode()):
            self._wrong = 0
            return True
        self._wrong += 1
        if self._wrong >= FREE_TRIES:
            self._not_before = self._clock() + WAIT
        return False
