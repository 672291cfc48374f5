# SPDX-License-Identifier: BSD-3-Clause
"""When the first sound was captured, by the chunks in which the voice node listens."""

from __future__ import annotations

import queue
import time
from collections.abc import Sequence
from contextlib import suppress

import numpy as np

SILENT = 3  # of 32767
SETTLE = 1.0  # [s] of the first sound until its true time shows; words begin later


class FirstSound:
    """Fed with chunks by one thread, waited for by another."""

    def __init__(self, is_file: bool) -> None:
        """Nothing heard so far.

        Args:
            is_file: The node reads a file, whose beginning its samples are counted from; else the
                first sound is the first that is no silence.
        """
        self._is_file = is_file
        self._heard: queue.Queue[tuple[float, float | None]] = queue.Queue()

    def push(self, stamp: float, first_sample: int, rate: int, samples: Sequence[int]) -> None:
        """Take the next chunk.

        Args:
            stamp: When its first sample was captured, or later [s].
            first_sample: Its index since the node began to listen.
            rate: Sampling rate [Hz].
            samples: (n,) of 16 bits.
        """
        loud = np.abs(np.asarray(samples, dtype=np.int32)) > SILENT
        first = (first_sample + int(loud.argmax())) / rate if loud.any() else None
        self._heard.put((stamp - first_sample / rate, 0.0 if self._is_file else first))

    def wait_until_it_listens(self, within: float) -> None:
        """Wait for the first chunk: of what is played before it, the beginning is lost.

        Raises:
            RuntimeError: None came within this time [s].
        """
        end = time.monotonic() + within
        while self._heard.empty():
            if time.monotonic() > end:
                raise RuntimeError(f"no sound from the voice node within {within:g} s")
            time.sleep(0.02)

    def wait(self, within: float) -> float:
        """Wait for the first sound; gives when it was captured [s].

        Raises:
            RuntimeError: All was silent for this time [s].
        """
        began, at, end = float("inf"), None, time.monotonic() + within
        while time.monotonic() < end:
            with suppress(queue.Empty):
                start, found = self._heard.get(timeout=0.1)
                began = min(began, start)  # what comes late looks as if it were captured late
                if at is None and found is not None:
                    at, end = found, time.monotonic() + SETTLE
        if at is None:
            raise RuntimeError(f"the voice node heard nothing within {within:g} s")
        return began + at
