# SPDX-License-Identifier: BSD-3-Clause
"""A piece of what `make bench ONLY=site.stops` measures."""

from contextlib import nullcontext

import pytest

from bench.common import resumable
from bench.common.part import MEASURED
from bench.site import stops


@pytest.fixture
def one_trial(monkeypatch):
    monkeypatch.setattr(stops, "PIECE", 1)
    monkeypatch.setattr(stops, "EVERY", 1)


def test_a_bridge_lost_at_full_speed_leaves_the_shaft_in_the_trocar_and_the_way_back_open(
    one_trial,
):
    (trial,) = stops._trials("bridge lost", 0)
    assert trial.speed == pytest.approx(stops.SPEED, rel=0.06)
    assert 0.0 < trial.error < 1e-3 and trial.way > 1e-3
    assert trial.way_back == "" and trial.beside == ""


class IdleRig:
    """In the place of a robot that is homed, where no drill leads it."""

    def __init__(self, _motion):
        pass

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def run(self, _seconds):
        pass

    def home(self):
        pass


def test_a_course_that_is_refused_counts_and_the_way_back_is_tried(one_trial, monkeypatch):
    calls = iter([stops.Stopped(0.02, 1e-5, 5e-3, None), stops.DoesNotSetOff("joint_2 starts")])

    def drill(self, name):
        found = next(calls)
        if isinstance(found, Exception):
            raise found
        return found

    monkeypatch.setattr(stops, "PIECE", 2)
    monkeypatch.setattr(stops, "KinovaRig", IdleRig)
    monkeypatch.setattr(stops.Drill, "__init__", lambda self, rig, rng: None)
    monkeypatch.setattr(stops.Drill, "__call__", drill)
    monkeypatch.setattr(stops.Drill, "go_on", lambda self: "still")
    calls = iter([*list(calls), stops.Stopped(0.02, 2e-5, 5e-3, "")])
    found = stops._trials("bridge lost", 0)
    assert [(t.way_back, t.beside) for t in found] == [("still", "joint_2 starts"), ("", "")]
    figures = {f.name: f for f in stops._figures("bridge lost", found)}
    assert figures["bridge lost: goes on by voice"].value == 50.0
    assert figures["bridge lost: bridge takes no course next"].value == 1


@pytest.mark.parametrize("trials", [200, 100])
def test_a_part_of_the_work_rests_on_the_kind_with_the_fewest_trials(monkeypatch, tmp_path, trials):
    def carried_out(part, jobs, one, processes):
        for job, path in list(jobs)[:-1]:  # time is up before the last
            resumable.write(tmp_path / path.name, one(job))
            yield tmp_path / path.name

    trial = stops.Stopped(0.02, 1e-5, 5e-3, "")
    monkeypatch.setattr(stops, "TRIALS", trials)
    monkeypatch.setattr(stops, "_trials", lambda name, share: [trial] * stops.PIECE)
    monkeypatch.setattr(resumable, "pool", lambda *_: nullcontext())
    monkeypatch.setattr(resumable, "carried_out", carried_out)
    first, *figures = stops.measure()
    assert (first.name, first.value, first.target) == (MEASURED, trials - 50, 200)
    assert len(figures) == 5 * len(stops.KINDS)
    assert f"({trials} trials" in figures[0].note and f"({trials - 50} trials" in figures[-5].note
