# SPDX-License-Identifier: BSD-3-Clause
"""The spotter in a thread of its own, so that nothing that recognition does delays it."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

from voice_assist.side_inputs import Observer, SideInput, SideInputKind, ignore
from voice_assist.spotter.spotter import Spotted, Spotting
from voice_assist.spotter.view import SpotterView
from voice_assist.types import Frame


class SpotterThread(SpotterView):
    """Takes frames without ever blocking the caller that brings them; the oldest give way.

    To the pipeline it is a spotter that has heard each frame when the pipeline has, and none that
    comes after: the pipeline waits for the thread for up to `patience`. So what both decide is a
    function of the sound, however busy the machine is. After a wait in vain it does not wait again
    until the thread has caught up.
    """

    def __init__(
        self,
        spotter: Spotting,
        capacity: int,
        on_spotted: Callable[[Spotted], None],
        on_failure: Callable[[Exception], None],
        patience: float,
        observer: Observer = ignore,
    ) -> None:
        """Prepare; `start` begins.

        Args:
            spotter: Used by the thread alone, but for `best`.
            capacity: Frames that may wait.
            on_spotted: Called in the thread at once.
            on_failure: Called in the thread as it ends by an error.
            patience: Longest wait of the pipeline for the thread [s].
            observer: Gets frames that it was late for, or never took.
        """
        super().__init__(spotter)
        self._capacity, self._patience = capacity, patience
        self._on_spotted, self._on_failure, self._observer = on_spotted, on_failure, observer
        self._ready = threading.Condition()
        self._frames: deque[Frame] = deque()
        self._is_in_step = True
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
                lost = self._frames.popleft()
                self._observer(SideInput(SideInputKind.SPOTTER_DROPPED, lost.first_sample))
                self.dropped += 1
            self._frames.append(frame)
            self._ready.notify_all()

    def close(self) -> None:
        """End the thread, once it has heard what waits."""
        with self._ready:
            self._is_over = True
            self._ready.notify_all()
        self._thread.join()

    def __call__(self, frame: Frame) -> Spotted | None:
        """What was spotted up to that frame, which itself came by `feed`."""
        with self._ready:
            self._wait_for(frame.next_sample)
            self._note(frame)
            return self._show(frame, is_late=self._heard_until < frame.next_sample)

    def _wait_for(self, until: int) -> None:
        def is_there() -> bool:
            return self._heard_until >= until or self.has_failed

        patience = self._patience if self._is_in_step else 0.0
        self._is_in_step = self._ready.wait_for(is_there, patience)

    def _note(self, frame: Frame) -> None:
        """Say so where the pipeline sees less than the sound alone would show it."""
        is_heard = self._heard_until >= frame.next_sample
        if self._is_deaf or (is_heard and not self.has_failed):
            return
        self._is_deaf = self.has_failed
        kind = SideInputKind.SPOTTER_FAILED if self.has_failed else SideInputKind.SPOTTER_LATE
        self._observer(SideInput(kind, frame.first_sample, self._heard_until))

    def _run(self) -> None:
        import torch

        torch.set_num_threads(1)  # holds for the thread that says it; two would wait for each other
        try:
            while (frame := self._next()) is not None:
                spotted = self._spotter(frame)
                if spotted is not None:
                    self._on_spotted(spotted)
                with self._ready:
                    self._note_heard(frame, spotted)
                    self._ready.notify_all()
        except Exception as error:  # top of a thread: the recogniser must know that it is alone
            with self._ready:
                self.has_failed = True
                self._ready.notify_all()
            self._on_failure(error)

    def _next(self) -> Frame | None:
        """The next frame; None: it is over."""
        with self._ready:
            self._ready.wait_for(lambda: self._frames or self._is_over)
            return self._frames.popleft() if self._frames else None
