# SPDX-License-Identifier: BSD-3-Clause
"""What a late tension has to be taken for."""

from __future__ import annotations

import numpy as np
import pytest

from rst_control.planning.patient_surface import TrocarPose
from rst_control.supervision.node_liveness import NodeLiveness
from rst_control.supervision.plausibility import SensorWatch, max_joint_speed
from rst_control.supervision.watchdogs import MonitoredMotion, WatchdogLimits, Watchdogs
from rst_control.tension.delay_bound import DelayBound
from rst_control.types import Measurement
from tests.unit.rst_control.support.executor_rig import shared


def fed(delay: float, tensions: list[float], period: float = 0.002) -> DelayBound:
    bound = DelayBound(delay)
    for k, tension in enumerate(tensions):
        bound.update(k * period, tension)
    return bound


def test_a_steady_rise_is_expected_to_have_gone_on_for_the_delay() -> None:
    rate = 3.0  # [N/s]
    bound = fed(0.05, [rate * 0.002 * k for k in range(100)])
    assert bound.ahead == pytest.approx(rate * 0.05)


def test_a_tension_that_is_not_late_needs_nothing_added() -> None:
    assert fed(0.0, [0.0, 1.0, 2.0]).ahead == 0.0


def test_what_falls_or_stays_adds_nothing() -> None:
    assert fed(0.05, [2.0 - 0.01 * k for k in range(100)]).ahead == 0.0
    assert fed(0.05, [1.5] * 100).ahead == 0.0


def test_an_old_rise_is_forgotten() -> None:
    assert fed(0.05, [0.01 * k for k in range(100)] + [0.99] * 30).ahead == 0.0


def test_sparse_readings_do_not_count_for_more_than_the_delay() -> None:
    """At 40 Hz with a delay of 8 ms, a whole step lies in one reading; a third of it counts."""
    bound = fed(0.008, [0.0, 0.3], period=0.025)
    assert bound.ahead == pytest.approx(0.3 * 0.008 / 0.025)


def test_readings_that_are_not_newer_are_passed_over() -> None:
    bound = fed(0.05, [0.0, 0.1])
    bound.update(0.002, 5.0)
    assert bound.ahead == pytest.approx(0.1)


def judged(delay: float, invalid_until: float = 0.0) -> str:
    """What the watchdogs say of 2.0 N that rose by 10 N/s, reported late by a delay [s]."""
    settings = shared()[0].controller
    watchdogs = Watchdogs(
        WatchdogLimits(settings.watchdogs, 1e-3, 2.4, delay),
        SensorWatch(settings, max_joint_speed(shared()[0].limits)),
        NodeLiveness(),
    )
    still, now = np.zeros(10), 0.0
    place = TrocarPose(error=1e-6, insertion=0.12, wrist=0.09, height=-0.13, is_outside=False)
    watched = MonitoredMotion(still, place, True, False, 0.1, None)
    for k in range(101):
        now = 0.002 * k
        force = np.array([0.0, 0.0, -10.0 * now])
        invalid = "only 1 torque readings so far" if now < invalid_until else ""
        measured = Measurement(
            still, still, still, now, force, gripped=True, tension_invalid_reason=invalid
        )
        watchdogs.update(measured, None, None)
    return watchdogs.motion(now, measured, watched)


def test_a_pull_is_stopped_before_the_limit_by_the_rate_times_the_delay() -> None:
    assert judged(0.008) is None  # 2.0 N and 0.08 N more
    assert (
        judged(0.05).words == "tension 2.00 N and 0.50 N more since it was measured, allowed 2.40 N"
    )


def test_from_a_tension_that_was_not_trusted_nothing_rose() -> None:
    assert judged(0.05, invalid_until=0.1995) is None
    assert "0.50 N more" in judged(0.05, invalid_until=0.14).words
