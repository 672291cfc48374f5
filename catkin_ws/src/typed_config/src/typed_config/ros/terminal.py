# SPDX-License-Identifier: BSD-3-Clause
"""A node's words for the terminal, written by a thread of their own.

A terminal that is stopped (Ctrl-S), or a link to it that hangs, keeps only that thread waiting.
"""

from __future__ import annotations

import logging
import threading
from contextlib import suppress
from logging.handlers import QueueHandler
from queue import Full, Queue
from typing import Final

from rosgraph.roslogging import RosStreamHandler

KEPT: Final = 1000  # words that wait; further ones are lost
WITHIN: Final = 1.0  # [s] for the last words at the end


def write_beside() -> None:
    """Let what rospy logs be written beside its callers; call it after rospy.init_node."""
    logger = logging.getLogger("rosout")
    for handler in list(logger.handlers):
        if isinstance(handler, RosStreamHandler):
            logger.removeHandler(handler)
            logger.addHandler(Beside(handler))


class Beside(QueueHandler):
    """Hands what is logged to a thread.

    Args:
        writer: Writes it there.
    """

    def __init__(self, writer: logging.Handler) -> None:
        self._records: Queue[logging.LogRecord | None] = Queue(KEPT)
        super().__init__(self._records)
        self.setLevel(writer.level)
        self._writer = writer
        self._thread = threading.Thread(target=self._run, name="terminal", daemon=True)
        self._thread.start()

    def enqueue(self, record: logging.LogRecord) -> None:
        """Let it be written soon."""
        with suppress(Full):
            self._records.put_nowait(record)

    def close(self) -> None:
        """Wait until all is written, at most for WITHIN; logging calls it at the exit."""
        with suppress(Full):
            self._records.put_nowait(None)
        self._thread.join(WITHIN)
        super().close()

    def _run(self) -> None:
        while (record := self._records.get()) is not None:
            self._writer.emit(record)  # without its lock, which the exit takes
