# SPDX-License-Identifier: BSD-3-Clause
"""A drawn part of what `make bench ONLY=site.tension` measures, and the fault that it came from."""

from dataclasses import replace

import numpy as np
import pytest

from bench.site.held_tissue import HeldTissue, Spring, site
from bench.site.sensors import KINDS, ONSETS, Failure, Sensor, SensorFault, healthy
from bench.site.tension import ABOVE, WAYS, carry_out, draw_situation, judge
from rst_control.supervision.tension_trust import TensionTrust
from rst_control.tension.falls_at_rest import FallsAtRest

LIMIT = site(200.0, False).controller.tension.limit


@pytest.mark.parametrize("index", range(20_000, 20_000 + 2 * len(KINDS)))
def test_no_fault_of_the_sensor_passes_the_limit(index, motion_config):
    """Of each kind one at the rate of the product, and one as the bench judges it."""
    drawn, rate = draw_situation(index), motion_config.controller.rate
    is_first = index < 20_000 + len(KINDS)
    assert (carry_out(drawn, rate) if is_first else judge(drawn)).peak <= ABOVE * LIMIT


@pytest.mark.parametrize("index", range(30_000, 30_004))
def test_the_slower_loop_of_the_bench_pulls_as_far_as_the_products(index, motion_config):
    drawn = replace(draw_situation(index), fault=healthy(np.random.default_rng(index)))
    full = carry_out(drawn, motion_config.controller.rate)
    assert carry_out(drawn).peak == pytest.approx(full.peak, abs=0.05)


@pytest.mark.parametrize(("index", "is_above"), [(987, True), (988, False)])
def test_what_is_above_the_limit_in_the_slower_loop_is_judged_at_the_rate_of_the_product(
    index, is_above, motion_config
):
    drawn, full = draw_situation(index), motion_config.controller.rate
    assert (carry_out(drawn).peak > LIMIT) is is_above
    assert judge(drawn) == (carry_out(drawn, full) if is_above else carry_out(drawn))


def test_every_fault_begins_at_every_moment_and_commands_come_by_every_way_in_both_units():
    drawn = [draw_situation(index) for index in range(400)]
    steps = [step for one in drawn for step in one.steps]
    assert {(d.fault.kind, d.fault.onset) for d in drawn} == {(k, o) for k in KINDS for o in ONSETS}
    given = {(s.way, bool(s.tension), bool(s.distance)) for s in steps}
    units = [(False, False), (True, False), (False, True)]
    assert given == {(way, *unit) for way in WAYS for unit in units}
    assert max(len(one.steps) for one in drawn) == 20


def test_an_amount_is_the_same_in_words_and_in_fields():
    def peak(way):
        drawn = replace(draw_situation(0), fault=healthy(np.random.default_rng(1)))
        drawn = replace(drawn, first=0.3, tissue=Spring(drawn.stiffest, 0.0, 0.0))
        return carry_out(replace(drawn, steps=tuple(replace(s, way=way) for s in drawn.steps)))

    by_action = peak("action")
    assert by_action.accepted > 1
    for way in ("voice", "service"):
        assert peak(way).accepted == by_action.accepted
        assert peak(way).peak == pytest.approx(by_action.peak, abs=1e-3)


def test_a_drift_that_pull_after_pull_hides_is_found_at_rest(monkeypatch):
    """One of 4,000 drawn: tissue that stiffens twentyfold, and a drift of 0.2 N/s."""
    peak = carry_out(draw_situation(353))
    assert peak.peak <= LIMIT and "while nothing moved" in peak.invalid_reason
    monkeypatch.setattr(FallsAtRest, "total", 0.0)
    assert carry_out(draw_situation(353)).peak > ABOVE * LIMIT


def test_a_sensor_that_is_scaled_for_one_pull_only_is_bounded_by_distance_too():
    """One of 10,000 drawn: for a second it read 0.64 of the tension, then all of it."""
    drawn = draw_situation(3917)
    assert drawn.fault.kind == "alternating" and drawn.is_bound
    assert judge(drawn).peak <= LIMIT
    assert judge(replace(drawn, is_bound=False)).peak > LIMIT


def rig_with(kind, reported, *, is_bound=False, noise=0.0, waits=0.2):
    """Tissue of 200 N/m and a sensor that reports this of the force from the start, made ready."""
    failure = Failure(lambda: lambda _, force: reported(force))
    fault = SensorFault(kind, failure, "before", 0.0, noise, 7)
    rig = HeldTissue(site(200.0, is_bound), Spring(200.0, 0.0, 0.0), Sensor(fault))
    rig.run(waits)
    rig.give("hey robot")
    return rig


@pytest.mark.parametrize("gain", ["checked", "unchecked"])
def test_a_sensor_that_reads_a_third_is_bounded_by_distance_where_its_gain_is_unchecked(gain):
    rig = rig_with("scaled", lambda force: 0.3 * force, is_bound=gain == "unchecked")
    rig.finish("tense", tension=1.0)
    for _ in range(4):
        rig.finish("pull more")
    assert rig.invalid_reason == ""
    assert rig.peak == pytest.approx(LIMIT if gain == "unchecked" else 6.0, abs=0.01)


def stuck_at_one_newton():
    rig = rig_with("stuck", lambda force: force / max(np.linalg.norm(force), 1.0), noise=0.005)
    assert rig.finish("tense", tension=0.95) == ""
    for _ in range(12):
        rig.finish("pull more")
        rig.run(0.3)
    return rig


def test_a_stuck_sensor_with_noise_cannot_be_pulled_on_step_by_step_until_the_next_grasp(
    monkeypatch,
):
    rig = stuck_at_one_newton()
    assert "sensor dead" in rig.invalid_reason
    assert rig.peak <= 2.0 + 1e-6  # what distances add up to on the stiffest tissue
    assert rig.executor.snapshot.measurement.tension_invalid_reason
    rig.finish("release")
    rig.run(0.5)
    assert rig.executor.snapshot.measurement.tension_invalid_reason == ""
    monkeypatch.setattr(TensionTrust, "judge", lambda self, measured, held: measured)
    assert stuck_at_one_newton().peak > LIMIT  # else the fault would not be one


@pytest.mark.parametrize("index", range(6))
def test_a_sensor_that_works_is_believed(index):
    rng = np.random.default_rng(index)
    drawn = draw_situation(index)
    tissue = Spring(drawn.stiffest * rng.uniform(0.3, 1.0), 0.0, 0.0)
    peak = carry_out(replace(drawn, fault=healthy(rng), tissue=tissue, is_bound=False))
    assert peak.invalid_reason == "" and peak.peak <= LIMIT


def test_jaws_that_are_empty_and_read_a_tension_make_the_next_pull_one_by_distance():
    rig = rig_with("offset", lambda force: force + 0.3, waits=0.5)
    assert "with nothing held, allowed 0.10 N" in rig.invalid_reason
    pending = rig.give("tense")
    assert "by distance" in pending.reply.result(0).message
