# SPDX-License-Identifier: BSD-3-Clause
"""The judge of stops: what it must call missed, late or well, by set-points made by hand."""

import json

import numpy as np
import pytest

from bench.safety.stops import suite
from bench.safety.stops.judge import JudgedStop, SetpointCourse, figures, latency, objection, rest
from tests.unit.bench.safety.test_network import PERIOD
from tests.unit.bench.safety.test_network import course as braking


def course(drift=0.0, **changes):
    """One joint that cruises, slows down from 0.1 s on, and rests; another may drift after it."""
    made = braking(**{"brakes": 0.1, "brake_time": 0.04, "end": 1.0, **changes})
    made.positions[:, 5] += drift * np.maximum(made.stamps - 0.6, 0.0)
    return made


def stop(**changes):
    fields = {
        "situation": "pulling",
        "way": "topic",
        "clients": 1,
        "latency": 0.001,
        "rest": 0.04,
        "rcm_error": 1e-7,
        "objection": "",
    }
    return JudgedStop(**{**fields, **changes})


@pytest.mark.parametrize("before", [0.0001, 0.001, 0.0019])
def test_latency_is_the_time_to_the_first_slower_set_point(before):
    asked = course()  # the set-point of 0.1 s still cruises, that of 0.102 s is slower
    assert latency(asked, 0.102 - before) == pytest.approx(before)
    assert objection(asked, 0.102 - before, 0.15) == ""


def test_braking_that_begins_late_counts_in_full():
    assert latency(course(), 0.0905) == pytest.approx(0.0115)


def test_a_set_point_due_at_the_moment_of_the_stop_is_not_its_answer():
    asked = course()
    assert latency(asked, asked.stamps[51]) == pytest.approx(PERIOD)


def test_at_rest_there_is_no_latency_and_nothing_to_object_to():
    asked = course()
    assert latency(asked, 0.3) is None and rest(asked, 0.3) is None
    assert objection(asked, 0.3, 0.15) == ""


def test_the_time_to_rest_is_that_of_the_first_set_point_that_stands():
    assert rest(course(brake_time=0.04), 0.1) == pytest.approx(0.04, abs=PERIOD)


def test_a_stop_that_nothing_answers_is_missed():
    asked = course(brakes=5.0)
    assert latency(asked, 0.3) == float("inf")
    assert objection(asked, 0.3, 0.15) == "no set-point slowed down"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"brake_time": 0.3}, "moved for 300 ms, allowed 150 ms"),
        ({"drift": 1e-3}, "after the rest"),
        ({"end": 0.2}, "not watched long enough"),
    ],
)
def test_braking_that_takes_too_long_a_creep_and_too_short_a_watch_are_named(changes, words):
    assert words in objection(course(**changes), 0.1, 0.15)


def test_a_controller_that_sends_nothing_leaves_holding_to_the_robot():
    nothing = SetpointCourse(np.empty(0), np.empty((0, 10)), np.empty((0, 10)))
    assert objection(nothing, 0.3, 0.15) == ""


def by_name(found):
    return {figure.name.split(": ", 1)[1]: figure for figure in found}


def test_figures_count_what_was_missed_and_say_which():
    missed = stop(latency=float("inf"), objection="no set-point slowed down")
    found = by_name(figures("here", [stop(), missed, stop(latency=None, rest=None)], 3, PERIOD))
    assert found["stops"].value == 3 and found["stops"].is_met
    assert found["missed"].value == 1 and found["missed"].is_met is False
    assert "pulling, by topic: no set-point" in found["missed"].note
    assert found["stops in motion"].value == 1
    assert found["stop received to first decelerating set-point p99"].value == pytest.approx(1.0)


def test_a_part_of_the_plan_is_never_called_met():
    found = by_name(figures("here", [stop()], 10_000, PERIOD))
    assert found["stops"].is_met is False
    assert found["missed"].is_met is None


def test_latency_and_rcm_error_have_their_targets():
    found = by_name(figures("here", [stop(latency=0.005, rcm_error=2e-5)] * 3, 3, PERIOD))
    assert found["stop received to first decelerating set-point p99"].is_met is False
    assert found["RCM error while stopping, max"].is_met is False


def test_chunks_that_are_kept_are_not_made_again(tmp_path, monkeypatch):
    for number in range(3):
        fields = stop(situation=f"chunk {number}").__dict__
        (tmp_path / f"{number:05d}.json").write_text(json.dumps([[fields, fields], []]))
    monkeypatch.setattr(suite, "run_chunk", None)  # making one would raise
    found, failures = suite.gather(tmp_path, 5)
    assert [s.situation for s in found] == [f"chunk {n}" for n in (0, 0, 1, 1, 2, 2)]
    assert failures == []
    assert len(suite.gather(tmp_path, 4)[0]) == 4


def test_other_code_of_the_bench_begins_anew(monkeypatch):
    before = suite.key()
    monkeypatch.setattr(suite, "OWN", suite.OWN[:-1])
    assert before == before.lower() and suite.key() != before
