# SPDX-License-Identifier: BSD-3-Clause
"""Waiting for what another process or thread does."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

_T = TypeVar("_T")
PATIENCE = 90.0  # [s] for anything to happen on a loaded machine; only what is broken takes longer


def wait_until(
    is_done: Callable[[], _T], what: str = "", limit: float = PATIENCE, every: float = 0.01
) -> _T:
    """Wait until something is so; returns what showed it.

    Args:
        is_done: Asked again and again; false while it is not so.
        what: It is, for the error.
        limit: Longest wait [s].
        every: Time between two questions [s].

    Raises:
        RuntimeError: It was not so within the limit.
    """
    end = time.monotonic() + limit
    while not (found := is_done()):
        if time.monotonic() > end:
            raise RuntimeError(f"not within {limit:g} s: {what}")
        time.sleep(every)
    return found
