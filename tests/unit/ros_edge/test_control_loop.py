# SPDX-License-Identifier: BSD-3-Clause
"""The thread of the control loop: what an exception in a tick leads to."""

import pytest

from rst_control.ros.controller import control_loop
from rst_control.ros.controller.control_loop import ControlLoop
from support.waiting import wait_until

PERIOD = 0.002  # [s]


@pytest.mark.parametrize("is_handled", [True, False])
def test_an_error_in_a_tick_is_handed_on_once_and_the_ticks_go_on(monkeypatch, is_handled):
    ticks, failures, said = [], [], []
    error = ArithmeticError("not a number")
    monkeypatch.setattr(control_loop, "spare_the_loop", lambda: None)
    monkeypatch.setattr(control_loop.log, "exception", lambda words, *parts: said.append(parts))

    def tick(due):
        ticks.append(due)
        if len(ticks) == 3:
            raise error

    def failed(failure):
        failures.append((len(ticks), failure))
        if not is_handled:
            raise RuntimeError("cannot brake")

    with ControlLoop(tick, failed, PERIOD) as loop:
        wait_until(lambda: len(ticks) >= 6 or not loop._thread.is_alive(), every=PERIOD)
        assert loop._thread.is_alive(), "an exception ended the loop"
    assert failures == [(3, error)]
    assert said == ([] if is_handled else [(error,)])
