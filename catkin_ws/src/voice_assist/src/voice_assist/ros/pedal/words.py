# SPDX-License-Identifier: BSD-3-Clause
"""Words for the log, written by a thread of their own."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from queue import Full, Queue
from typing import Final

KEPT: Final = 1000  # words that wait; further ones are lost

Log = Callable[..., None]  # such as rospy.loginfo


class Words:
    """Keeps nobody waiting: a terminal that is stopped (Ctrl-S) blocks only this thread."""

    def __init__(self) -> None:
        self._queue: Queue[tuple[Log, tuple[object, ...]] | None] = Queue(KEPT)
        self._thread = threading.Thread(target=self._run, name="words", daemon=True)
        self._thread.start()

    def __call__(self, log: Log, *words: object) -> None:
        """Log it soon.

        Args:
            log: Function that does it.
            words: Its arguments.
        """
        with suppress(Full):
            self._queue.put_nowait((log, words))

    def close(self, within: float) -> None:
        """Wait until all is written, at most so long [s]."""
        with suppress(Full):
            self._queue.put_nowait(None)
        self._thread.join(within)

    def _run(self) -> None:
        while (one := self._queue.get()) is not None:
            log, words = one
            log(*words)
