# SPDX-License-Identifier: BSD-3-Clause
"""The thread that ticks the executor at a fixed rate, whatever the other threads do."""

from __future__ import annotations

import ctypes
import gc
import logging
import os
import threading
import time
from collections.abc import Callable
from contextlib import suppress

from rst_control.execution.loop_statistics import LoopStatistics
from rst_control.ros.common.priority import spare_the_loop

log = logging.getLogger("rosout.rst_control.loop")

_PR_SET_TIMERSLACK = 29
_TIMER_SLACK = 1_000  # [ns] how much later than asked the kernel may wake the loop


class ControlLoop:
    """Calls `tick` at absolute times, one period apart; a late tick does not delay those after it.

    Args:
        tick: What to do; its argument is the time at which it is due, by time.monotonic() [s].
        failed: What to do when `tick` raised: brake and report.
        period: Time between ticks [s].
    """

    def __init__(
        self, tick: Callable[[float], None], failed: Callable[[Exception], None], period: float
    ) -> None:
        self._tick, self._failed, self._period = tick, failed, period
        self.statistics = LoopStatistics(late_after=0.5 * period)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="control_loop", daemon=True)

    def __enter__(self) -> ControlLoop:
        spare_the_loop()
        gc.disable()  # the node collects by itself, while nothing moves
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join(timeout=1.0)
        gc.enable()

    def _run(self) -> None:
        _sharpen_timers()
        _go_first()
        due = time.monotonic() + self._period
        while not self._ended.is_set():
            _sleep_until(due)
            began = time.monotonic()
            try:
                self._tick(due)
            except Exception as error:  # the top of the thread: brake, report, go on
                self._report(error)
            ended = time.monotonic()
            self.statistics.record(began - due, ended - began)
            due += self._period
            if ended > due + self._period:
                missed = int((ended - due) / self._period)
                self.statistics.skip(missed)
                due += missed * self._period

    def _report(self, error: Exception) -> None:
        try:
            self._failed(error)
        except Exception:  # the next tick will fail again, and say so again
            log.exception("error while handling %r", error)


def _sleep_until(due: float) -> None:
    time.sleep(max(due - time.monotonic(), 0.0))  # of no length, too: see SimulationPace.wait


def _go_first() -> None:
    """Where the node runs in real time, run before its other threads."""
    with suppress(OSError, AttributeError):
        if os.sched_getscheduler(0) == os.SCHED_RR:
            level = os.sched_getparam(0).sched_priority + 1
            os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(level))


def _sharpen_timers() -> None:
    try:
        ctypes.CDLL(None).prctl(_PR_SET_TIMERSLACK, _TIMER_SLACK, 0, 0, 0)
    except (OSError, AttributeError):
        log.info("no prctl here: the loop wakes with the system's usual timer slack")
