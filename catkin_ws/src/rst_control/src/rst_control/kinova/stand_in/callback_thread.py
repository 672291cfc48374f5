# SPDX-License-Identifier: BSD-3-Clause
"""The one thread in which Kinova's driver handles all that comes in by ROS (`ros::spin`).

While it is at one message, which for a goal lasts more than a second, nothing else is handled: no
cancel, no velocity, and no "stop" either. Of each topic only the newest message waits.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator
from dataclasses import dataclass

Work = Generator[float, None, None]  # does something, yields how long it then waits [s], ...


@dataclass(eq=False)
class _Waiting:
    topic: str
    start: Callable[[], Work]


class CallbackThread:
    """Runs work one after another in simulated time."""

    def __init__(self) -> None:
        self._queue: deque[_Waiting] = deque()
        self._work: Work | None = None
        self._wakes = 0.0

    @property
    def is_busy(self) -> bool:
        """Something is being done or waits to be done."""
        return self._work is not None or bool(self._queue)

    def post(self, topic: str, start: Callable[[], Work], keep_all: bool = False) -> None:
        """Leave work; it takes the place of what waits from the same topic, unless all is kept."""
        if not keep_all:
            for waiting in self._queue:
                if waiting.topic == topic:
                    waiting.start = start
                    return
        self._queue.append(_Waiting(topic, start))

    def advance(self, now: float) -> None:
        """Do all that is due by a time [s], which never goes back."""
        while self.is_busy:
            if self._work is None:
                self._work = self._queue.popleft().start()
            if now < self._wakes:
                return
            try:
                self._wakes += next(self._work)
            except StopIteration:
                self._work = None
        self._wakes = now  # idle: what comes next begins when it comes
