# SPDX-License-Identifier: BSD-3-Clause
"""Who may give commands, and how often; a stop is taken from anybody, at any time.

In ROS 1 a caller's name is what the caller says it is. So this guards against mistakes, such as a
script left running or a second panel, and against floods. It guards against no attacker.
"""

from __future__ import annotations

import re
import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from rst_control.config.callers import CallersConfig
from rst_control.types import Cause, Reason
from typed_config.node_names import is_allowed

MAX_CALLERS: Final = 256  # that are counted one by one; all others share one budget
PAUSE: Final = 0.1  # [s] that the answer to a call beyond the budget waits, as must its sender
NEWS_PERIOD: Final = 1.0  # [s] between entries in the event log about one caller

_ANONYMOUS = re.compile(r"_\d+_\d+$")  # what rospy and roscpp append: process and time


@dataclass(frozen=True)
class Admission:
    """What becomes of one call."""

    refusal: Cause | None  # why it is not taken; None: it is
    pause: float  # [s] by which its answer is held back
    is_news: bool  # the refusal belongs into the event log; False: one like it came just before


class Budget:
    """A token bucket: `rate` calls per second on average, `burst` at once.

    Args:
        rate: [1/s].
        burst: Calls.
        now: Time [s].
    """

    def __init__(self, rate: float, burst: int, now: float) -> None:
        self._rate, self._burst = rate, burst
        self._left, self._since = float(burst), now
        self._noted = float("-inf")  # [s] when the last refusal was news

    def take(self, now: float) -> bool:
        """Take one call out of it, if one is left."""
        self._fill(now)
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True

    def is_full(self, now: float) -> bool:
        """Nothing was taken for so long that forgetting it changes nothing."""
        self._fill(now)
        return self._left >= self._burst

    def is_news(self, now: float) -> bool:
        """Whether a refusal at this time belongs into the event log."""
        if now - self._noted < NEWS_PERIOD:
            return False
        self._noted = now
        return True

    def _fill(self, now: float) -> None:
        passed = max(0.0, now - self._since)
        self._left = min(float(self._burst), self._left + passed * self._rate)
        self._since = now


class CallLimiter:
    """Admits calls or refuses them; from any thread.

    Args:
        config: Who may call, and how often.
        clock: Time [s].
    """

    def __init__(self, config: CallersConfig, clock: Callable[[], float]) -> None:
        self._config, self._clock = config, clock
        self._lock = threading.Lock()
        self._budgets: OrderedDict[str, Budget] = OrderedDict()  # the longest silent first
        self._others = self._new_budget()

    def admit(self, caller: str, is_stop: bool = False) -> Admission:
        """Decide about one call.

        Args:
            caller: Its name, as `node_names.caller_name` gives it.
            is_stop: The call is a stop. It is admitted, and counted as all others are, so that a
                flooding caller waits for the answer, after the stop.
        """
        with self._lock:
            now = self._clock()
            budget = self._budget(family(caller), now)
            pause = 0.0 if budget.take(now) else PAUSE
            refusal = None if is_stop else self._refusal(caller, pause > 0.0)
            return Admission(refusal, pause, refusal is not None and budget.is_news(now))

    @property
    def counted(self) -> int:
        """How many callers are counted one by one at present."""
        return len(self._budgets)

    def _refusal(self, caller: str, is_too_often: bool) -> Cause | None:
        config = self._config
        if not is_allowed(caller, config.allowed):
            allowed = ", ".join(config.allowed)
            words = f'{caller} may not give commands, allowed: {allowed}; "stop" is always taken'
            return Cause(Reason.MAY_NOT_COMMAND, words)
        if is_too_often:
            limit = f"{config.rate:g} per second after {config.burst} at once"
            words = f'too many calls from {caller}, allowed: {limit}; "stop" is always taken'
            return Cause(Reason.TOO_MANY_CALLS, words)
        return None

    def _budget(self, name: str, now: float) -> Budget:
        known = self._budgets.get(name)
        if known is None:
            if len(self._budgets) >= MAX_CALLERS:
                oldest = next(iter(self._budgets))
                if not self._budgets[oldest].is_full(now):
                    return self._others
                del self._budgets[oldest]
            known = self._budgets[name] = self._new_budget()
        self._budgets.move_to_end(name)
        return known

    def _new_budget(self) -> Budget:
        return Budget(self._config.rate, self._config.burst, self._clock())


def family(caller: str) -> str:
    """What nodes have in common that are started anew for each call, such as `rosservice call`."""
    return _ANONYMOUS.sub("_*", caller)
