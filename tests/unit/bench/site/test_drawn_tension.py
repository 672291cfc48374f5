# SPDX-License-Identifier: BSD-3-Clause
"""A drawn part of what `make bench ONLY=site.tension` measures, and the fault that it came from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.site.held_tissue import HeldTissue, Spring, site
from bench.site.sensors import KINDS, Sensor, SensorFault, healthy
from bench.site.tension import ABOVE, carry_out, draw_situation
from rst_control.supervision.tension_trust import TensionTrust

LIMIT = site(200.0, False).controller.tension.limit


@pytest.mark.parametrize("index", range(20_000, 20_000 + 2 * len(KINDS)))
def test_no_fault_of_the_sensor_passes_the_limit(index, motion_config):
    rate = motion_config.controller.rate
    assert carry_out(draw_situation(index), rate).peak <= ABOVE * LIMIT


@pytest.mark.parametrize("index", range(30_000, 30_004))
def test_the_slower_loop_of_the_bench_pulls_as_far_as_the_products(index, motion_config):
    drawn = replace(draw_situation(index), fault=healthy(np.random.default_rng(index)))
    full = carry_out(drawn, motion_config.controller.rate)
    assert carry_out(drawn).peak == pytest.approx(full.peak, abs=0.05)


def stuck_at_one_newton():
    fault = SensorFault("stuck", _stuck, "before", 0.0, 0.005, 7)
    rig = HeldTissue(site(200.0, False), Spring(200.0, 0.0, 0.0), Sensor(fault))
    rig.run(0.2)
    rig.give("hey robot")
    assert rig.finish("tense", tension=0.95) == ""
    for _ in range(12):
        rig.finish("pull more")
        rig.run(0.3)
    return rig


def _stuck():
    def fault(since, force):
        length = np.linalg.norm(force)
        return force if length <= 1.0 else force / length

    return fault


def test_a_stuck_sensor_with_noise_cannot_be_pulled_on_step_by_step(monkeypatch):
    rig = stuck_at_one_newton()
    assert "sensor dead" in rig.distrust
    assert rig.peak <= 2.0 + 1e-6  # what distances add up to on the stiffest tissue
    monkeypatch.setattr(TensionTrust, "judge", lambda self, measured, held: measured)
    assert stuck_at_one_newton().peak > LIMIT  # else the fault would not be one


def test_after_the_release_the_next_grasp_is_judged_anew():
    rig = stuck_at_one_newton()
    assert rig.executor.snapshot.measurement.tension_invalid_reason
    rig.finish("release")
    rig.run(0.5)
    assert rig.executor.snapshot.measurement.tension_invalid_reason == ""


@pytest.mark.parametrize("index", range(6))
def test_a_sensor_that_works_is_believed(index):
    rng = np.random.default_rng(index)
    drawn = draw_situation(index)
    tissue = Spring(drawn.stiffest * rng.uniform(0.3, 1.0), 0.0, 0.0)
    peak = carry_out(replace(drawn, fault=healthy(rng), tissue=tissue, is_bound=False))
    assert peak.distrust == "" and peak.peak <= LIMIT


def test_jaws_that_are_empty_and_read_a_tension_make_the_next_pull_one_by_distance():
    fault = SensorFault("offset", lambda: lambda since, force: force + 0.3, "before", 0.0, 0.0, 1)
    rig = HeldTissue(site(200.0, False), Spring(150.0, 0.0, 0.0), Sensor(fault))
    rig.run(0.5)
    rig.give("hey robot")
    assert "with nothing held, allowed 0.10 N" in rig.distrust
    pending = rig.give("tense")
    assert "by distance" in pending.reply.result(0).message
