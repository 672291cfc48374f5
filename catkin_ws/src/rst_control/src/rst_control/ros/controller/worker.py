# SPDX-License-Identifier: BSD-3-Clause
"""Threads beside the control loop: each repeats one step, and reports what goes wrong in it."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

log = logging.getLogger("rosout.rst_control.worker")


class Worker:
    """A thread that repeats a step until the context ends.

    Args:
        name: Of the thread, for reports.
        step: What to repeat; it waits for its work by itself, for at most a second or so.
        failed: Takes an exception in words, beside the log.
    """

    def __init__(self, name: str, step: Callable[[], None], failed: Callable[[str], None]) -> None:
        self._name, self._step, self._failed = name, step, failed
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def __enter__(self) -> Worker:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join(timeout=2.0)

    def _run(self) -> None:
        while not self._ended.is_set():
            try:
                self._step()
            except Exception as error:  # the top of the thread: report, go on
                if not self._ended.is_set():
                    log.exception("error in thread %s", self._name)
                    self._failed(f"{self._name}: {error!r}")
                    self._ended.wait(0.1)
