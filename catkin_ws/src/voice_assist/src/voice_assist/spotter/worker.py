# SPDX-License-Identifier: BSD-3-Clause
"""The spotter in a thread of its own, so that nothing that recognition does delays it."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import replace

import torch

from voice_assist.spotter.spotter import Spotted, Spotting
from voice_assist.types import Frame


class SpotterThread:
    """Takes frames without ever blocking who brings them; the oldest give way.

    To the pipeline it is a spotter that has heard its frames already. Once its thread has failed
    it says that nobody listens, and the recogniser decides alone.
    """

    def __init__(
        self,
        spotter: Spotting,
        capacity: int,
        on_spotted: Callable[[Spotted], None],
        on_failure: Callable[[Exception], None],
    ) -> None:
        """Prepare; `start` begins.

        Args:
            spotter: Used by the thread alone, but for `best`.
            capacity: Frames that may wait.
            on_spotted: Called in the thread at once.
            on_failure: Called in the thread as it ends by an error.
        """
        self._spotter, self._capacity = spotter, capacity
        self._on_spotted, self._on_failure = on_spotted, on_failure
        self._ready = threading.Condition()
        self._frames: deque[Frame] = deque()
        self._spotted: deque[Spotted] = deque()  # for the pipeline
        self._is_over = False
        self._thread = threading.Thread(target=self._run, name="spotter", daemon=True)
        self.dropped = 0  # frames
        self.has_failed = False

    def start(self) -> None:
        """Begin to listen."""
        self._thread.start()

    def feed(self, frame: Frame) -> None:
        """Bring a frame; returns at once."""
        with self._ready:
            if len(self._frames) >= self._capacity:
                self._frames.popleft()
                self.dropped += 1
            self._frames.append(frame)
            self._ready.notify()

    def close(self) -> None:
        """End the thread, once it has heard what waits."""
        with self._ready:
            self._is_over = True
            self._ready.notify()
        self._thread.join()

    def __call__(self, frame: Frame) -> Spotted | None:
        """What was spotted since the last call; the frame itself came by `feed`."""
        with self._ready:
            return self._spotted.popleft() if self._spotted else None

    def best(self, since: float) -> float | None:
        """See Spotting."""
        return None if self.has_failed else self._spotter.best(since)

    def reset(self) -> None:
        """Nothing: the stream that the thread hears goes on."""

    def _run(self) -> None:
        torch.set_num_threads(1)  # holds for the thread that says it; two would wait for each other
        try:
            while (frame := self._next()) is not None:
                spotted = self._spotter(frame)
                if spotted is not None:
                    self._on_spotted(spotted)
                    with self._ready:
                        self._spotted.append(replace(spotted, is_sent=True))
        except Exception as error:  # top of a thread: the recogniser must know that it is alone
            self.has_failed = True
            self._on_failure(error)

    def _next(self) -> Frame | None:
        """The next frame; None: it is over."""
        with self._ready:
            self._ready.wait_for(lambda: self._frames or self._is_over)
            return self._frames.popleft() if self._frames else None
