# SPDX-License-Identifier: BSD-3-Clause
"""The mode of the robot, which the voice takes over: it is also set by hand, pedal and action."""

from __future__ import annotations

from threading import Lock

from voice_assist.config.moving import MovingConfig
from voice_assist.pipeline.unanswered_calls import UnansweredCalls
from voice_assist.types import Mode


class RobotMode:
    """The newest report of it; inputs come from several threads.

    A report does not count while it may be older than a word that the voice itself passed on.
    All times are of one steady clock [s].
    """

    def __init__(self, config: MovingConfig) -> None:
        """Nothing is known."""
        self._config, self._lock = config, Lock()
        self.calls = UnansweredCalls(config.settle)  # words that the voice passes on
        self._mode = Mode.STANDBY
        self._reported_at = float("-inf")  # [s]

    def report(self, is_assistance_enabled: bool, now: float) -> None:
        """Take the controller's state as it comes."""
        with self._lock:
            self._mode = Mode.ACTIVE if is_assistance_enabled else Mode.STANDBY
            self._reported_at = now

    def __call__(self, now: float) -> Mode | None:
        """The robot's mode; None: it is unknown, or the voice may be about to change it."""
        with self._lock:
            is_fresh = now - self._reported_at <= self._config.state_age
            return self._mode if is_fresh and self.calls.are_settled(now) else None
