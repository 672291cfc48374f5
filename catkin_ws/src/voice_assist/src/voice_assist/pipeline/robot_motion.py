# SPDX-License-Identifier: BSD-3-Clause
"""Whether the robot moves, as far as the voice node can know; in doubt it does.

While it moves, every "stop" that is heard stops it. At rest a whole utterance decides.
"""

from __future__ import annotations

from threading import Lock

from voice_assist.config.moving import MovingConfig
from voice_assist.pipeline.unanswered_calls import UnansweredCalls

AT_REST = frozenset({"standby", "active", "halted", "faulted"})  # states of the controller


class RobotMotion:
    """The rule; its inputs come from several threads. All times are of one steady clock [s].

    The robot moves, or may:

    1. while the newest state of the controller is none of rest,
    2. from a motion that the node sends until `settle` after its answer,
    3. while that state is older than `state_age`, or none came yet, and assistance is enabled.
    """

    def __init__(self, config: MovingConfig) -> None:
        """Nothing is known, and assistance is not enabled."""
        self._config, self._lock = config, Lock()
        self._reported_at = float("-inf")  # [s]
        self._is_at_rest = True  # by the newest state
        self._is_assistance_reported = False  # by the newest state
        self._is_armed = False  # the voice mode is active
        self.calls = UnansweredCalls(config.settle)  # motions that the node sends

    def report(self, state: str, is_assistance_enabled: bool, now: float) -> None:
        """Take the controller's state as it comes."""
        with self._lock:
            self._reported_at, self._is_at_rest = now, state in AT_REST
            self._is_assistance_reported = is_assistance_enabled

    def arm(self, is_armed: bool) -> None:
        """Take whether motion commands count by voice."""
        with self._lock:
            self._is_armed = is_armed

    def is_moving(self, now: float) -> bool:
        """Whether it moves now, or may."""
        if not self._config.is_enabled:
            return False
        if not self.calls.are_settled(now):
            return True
        with self._lock:
            if now - self._reported_at <= self._config.state_age:
                return not self._is_at_rest
            return self._is_armed or self._is_assistance_reported or not self._is_at_rest
