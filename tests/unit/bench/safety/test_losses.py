# SPDX-License-Identifier: BSD-3-Clause
"""The judge of lost parts: what it must call late, resumed, unseen or well, by made traces."""

import importlib
import json
import sys
from dataclasses import asdict
from types import SimpleNamespace

import numpy as np
import pytest

import support.figures
from bench.__main__ import main
from bench.common import resumable
from bench.common.part import Part
from bench.safety.losses.judge import (
    GAP,
    STILL,
    JointTrace,
    LossRule,
    PartLoss,
    blindness,
    drift,
    figures,
    last_joint,
    last_movement,
    left,
    objections,
    speed,
)
from support.figures import RESULTS
from support.product_code import SYSTEM

PERIOD = 0.002
CRUISE = 0.05  # [rad/s]
HOLDS = LossRule("held", 0.1)
GOES_ON = LossRule("what eases goes on", 0.1, spares=("release",))


def trace(rest_at=1.04, end=3.0, resumes_at=None, way=1e-3):
    """Joint 3 cruises, and rests from a time on; joint 7 may go a way later on."""
    times = np.arange(0.0, end, PERIOD)
    positions = np.zeros((len(times), 10))
    positions[:, 3] = CRUISE * np.minimum(times, rest_at)
    if resumes_at is not None:
        positions[:, 7] = way * np.clip((times - resumes_at) / 0.1, 0.0, 1.0)
    return JointTrace(times, positions)


def loss(**changes):
    fields = {
        "victim": "controller",
        "way": "SIGKILL",
        "motion": "tense",
        "speed": 0.05,
        "joint": "joint_4",
        "alone": 0.04,
        "arm": 0.04,
        "stopped": None,
        "by": "",
        "drift": 0.0,
        "back": 4.0,
        "found": True,
        "objections": (),
        "load": 3.0,
    }
    return PartLoss(**{**fields, **changes})


def by_name(losses, rules, planned=None):
    return {f.name: f for f in figures(losses, rules, planned or len(losses))}


@pytest.fixture
def suite(monkeypatch):
    """The suite without its stage, which needs ROS."""
    stage = SimpleNamespace(RULES={}, stage_for=None)
    monkeypatch.setitem(sys.modules, "bench.safety.losses.stage", stage)
    yield importlib.import_module("bench.safety.losses.suite")
    del sys.modules["bench.safety.losses.suite"]


def test_losses_that_are_kept_are_of_the_code_of_the_whole_system(suite, monkeypatch):
    found = []
    for code in ("a", "b", "a"):
        suite.key.cache_clear()
        monkeypatch.setattr(suite, "identity", {SYSTEM: code}.__getitem__)
        found.append(suite.key())
    assert found[0] == found[2] != found[1]


def test_each_way_is_taken_as_often_and_what_is_kept_is_not_taken_again():
    twice, once = {"SIGKILL": 2, "SIGSTOP": 2}, {"SIGKILL": 1, "SIGSTOP": 1}
    assert left("robot", [], twice) == ["SIGKILL"] * 2 + ["SIGSTOP"] * 2
    assert left("robot", [loss()], twice) == ["SIGSTOP"] * 2 + ["SIGKILL"]
    assert left("robot", [loss(), loss(way="SIGSTOP")], once) == []
    assert left("recogniser", [loss(way="hang")], {"hang": 1, "crash": 1}) == ["crash"]
    assert left("robot", [], {"SIGKILL": 0, "SIGSTOP": 1}) == ["SIGSTOP"]


@pytest.mark.parametrize("rest", [0.004, 0.04, 0.0999, 0.1, 0.35])
def test_the_last_movement_is_found_to_a_sample_and_never_early(rest):
    found = last_movement(trace(rest_at=1.0 + rest), 1.0, 2.0)
    assert rest - STILL / CRUISE - 1e-9 <= found <= rest + PERIOD + 1e-9


@pytest.mark.parametrize(
    ("changes", "last"),
    [
        ({"rest_at": 0.9}, 0.0),  # it rested before
        ({"rest_at": 9.0}, np.inf),
        ({"rest_at": 1.95}, np.inf),  # hardly at rest
        ({"rest_at": 1.03, "resumes_at": 1.4}, pytest.approx(0.5, abs=2 * PERIOD)),
    ],
)
def test_the_last_movement_is_that_after_which_it_rests_until_the_end_of_the_watch(changes, last):
    assert last_movement(trace(**changes), 1.0, 2.0) == last


def test_the_joint_that_moved_last_is_named():
    assert last_joint(trace(), 1.0, 2.0) == 3
    assert last_joint(trace(resumes_at=1.4), 1.0, 2.0) == 7
    assert last_joint(trace(), 1.5, 2.0) is None


def test_slow_motion_counts_as_motion():
    times = np.arange(0.0, 3.0, PERIOD)
    slow = np.outer(np.minimum(times, 1.5), np.full(10, 5e-4))  # 0.5 mrad/s
    assert last_movement(JointTrace(times, slow), 1.0, 2.0) == pytest.approx(0.46, abs=0.01)


def test_set_points_that_end_at_once_moved_nothing_after_it():
    whole = trace(rest_at=9.0)
    ended = JointTrace(whole.times[whole.times < 1.0], whole.positions[whole.times < 1.0])
    assert last_movement(ended, 1.0, 2.0) == 0.0


def test_a_trace_with_a_hole_says_nothing():
    whole = trace()
    seen = (whole.times < 1.1) | (whole.times > 1.1 + 1.5 * GAP)
    holed = JointTrace(whole.times[seen], whole.positions[seen])
    assert blindness(whole, 1.0, 2.0) == ""
    assert blindness(holed, 1.0, 2.0).startswith("nothing was seen for 9")
    late = JointTrace(whole.times[whole.times < 1.5], whole.positions[whole.times < 1.5])
    assert blindness(late, 1.0, 2.0).startswith("nothing was seen for 50")


def test_an_empty_trace_is_blind_and_not_at_rest_for_sure():
    empty = JointTrace(np.empty(0), np.empty((0, 10)))
    assert last_movement(empty, 1.0, 2.0) == 0.0
    assert blindness(empty, 1.0, 2.0) == "nothing was seen for 1000 ms"
    assert drift(empty, 1.0, 2.0) == speed(empty, 1.0) == 0.0


def test_motion_that_resumes_is_seen_even_where_it_comes_back():
    assert drift(trace(resumes_at=1.5), 1.2, 2.5) == pytest.approx(1e-3)
    times = np.arange(0.0, 3.0, PERIOD)
    there_and_back = np.zeros((len(times), 10))
    there_and_back[:, 2] = 1e-3 * np.exp(-(((times - 2.0) / 0.05) ** 2))
    assert drift(JointTrace(times, there_and_back), 1.2, 2.9) == pytest.approx(1e-3)
    assert drift(trace(), 1.2, 2.5) == 0.0


def test_speed_is_that_of_the_fastest_joint_before_the_moment():
    assert speed(trace(), 1.0) == pytest.approx(CRUISE)
    assert speed(trace(), 2.0) == 0.0


def test_a_loss_as_documented_raises_nothing():
    assert objections(loss(), HOLDS) == []
    on = loss(motion="release", alone=float("inf"), stopped=0.05, by="topic")
    assert objections(on, GOES_ON) == []


@pytest.mark.parametrize(
    ("changes", "rule", "words"),
    [
        ({"alone": 0.15}, HOLDS, "moved for 150 ms, documented 100 ms"),
        ({"alone": float("inf")}, HOLDS, "moved for inf ms, documented 100 ms"),
        ({"drift": 1e-3}, HOLDS, 'moved by 1.000 mrad without "hey robot"'),
        ({"back": None}, HOLDS, "the next command did not move it"),
        ({"objections": ('"tense" was accepted',)}, HOLDS, '"tense" was accepted'),
        (
            {"motion": "release", "stopped": 0.2, "by": "topic"},
            GOES_ON,
            "moved for 200 ms after a stop by topic",
        ),
        (
            {"motion": "release, spoken", "alone": float("inf")},
            GOES_ON,
            "moved on, and no stop was tried",
        ),
        ({"alone": float("inf")}, GOES_ON, "moved for inf ms, documented 100 ms"),
    ],
)
def test_each_fault_is_named(changes, rule, words):
    assert objections(loss(**changes), rule) == [words]


def test_a_loss_that_is_as_documented_may_still_miss_the_demand():
    slow = loss(victim="voice", alone=0.55)
    rules = {"voice": LossRule("0.5 s after the heartbeat", 0.6)}
    found = by_name([slow, loss(victim="voice", alone=0.51)], rules)
    assert found["voice, SIGKILL: not as documented"].is_met
    assert found["voice, SIGKILL: loss to last movement max"].is_met is False
    assert found["arm and jaws at rest in time by the loss alone"].value == 0
    assert found["arm and jaws at rest in time by the loss alone"].is_met is False


def test_a_part_of_which_less_is_demanded_is_judged_by_that():
    rules = {"recogniser": LossRule("stopped by the voice node", 0.5, demanded=0.5)}
    found = by_name([loss(victim="recogniser", way="hang", alone=0.45)], rules)
    assert found["recogniser, hang: loss to last movement max"].is_met
    assert found["arm and jaws at rest in time by the loss alone"].is_met
    late = by_name([loss(victim="recogniser", way="hang", alone=0.51)], rules)
    assert late["recogniser, hang: loss to last movement max"].is_met is False
    assert late["arm and jaws at rest in time by the loss alone"].is_met is False


def test_what_moves_on_is_counted_and_misses_its_target():
    rules = {"recorder": GOES_ON}
    on = loss(victim="recorder", alone=float("inf"))
    found = by_name([on, loss(victim="recorder", alone=0.05)], rules)
    assert found["recorder, SIGKILL: moved on by itself"].value == 1
    assert found["recorder, SIGKILL: moved on by itself"].is_met is False
    assert found["arm and jaws at rest in time by the loss alone"].value == 1


def test_what_is_spared_is_judged_by_its_stop_alone():
    rules = {"recorder": GOES_ON}
    on = {"victim": "recorder", "motion": "release", "alone": float("inf"), "arm": float("inf")}
    found = by_name([loss(**on, stopped=0.05, by="service")], rules)
    assert found["recorder, SIGKILL: moved on by itself"].value == 0
    assert found["recorder, SIGKILL: a stop given meanwhile to last movement max"].is_met
    assert found["arm and jaws at rest in time by the loss alone"].target == 0


def test_arm_and_jaws_are_judged_apart():
    found = by_name([loss(alone=0.15, arm=0.06)], {"controller": HOLDS})
    assert found["arm at rest in time by the loss alone"].is_met
    assert found["arm and jaws at rest in time by the loss alone"].is_met is False
    assert found["controller, SIGKILL: loss to last movement of the arm max"].is_met


def test_a_loss_at_rest_shows_nothing_and_is_reported():
    found = by_name([loss(speed=1e-4, alone=0.0)], {"controller": HOLDS})
    assert found["controller, SIGKILL: in motion when lost"].is_met is False


def test_fewer_losses_than_planned_miss_their_target():
    rules = {"controller": HOLDS}
    assert by_name([loss()], rules, 2)["measured"].is_met is False
    good = by_name([loss(), loss(way="SIGSTOP")], rules)
    assert all(f.is_met is not False for f in good.values())
    assert good["arm and jaws at rest in time by the loss alone"].value == 2


def test_a_controller_that_nobody_finds_is_reported():
    found = by_name([loss(victim="roscore", found=False)], {"roscore": HOLDS})
    assert found["roscore, SIGKILL: new clients do not find the controller"].is_met is False


def test_what_is_kept_is_read_again_infinity_included(tmp_path):
    rows, kept = tmp_path / "robot.jsonl", loss(alone=float("inf"), objections=("one", "two"))
    resumable.append(rows, "a", asdict(kept))
    (row,) = resumable.rows_of(rows, "a")
    assert PartLoss.from_json(row) == kept


def test_a_loss_beside_other_work_or_at_the_end_of_its_motion_is_taken_again() -> None:
    aside = [loss(load=4.1), loss(finished=True), loss(load=9.0, alone=float("inf"))]
    twice = {"SIGKILL": 2, "SIGSTOP": 2}
    assert left("controller", [loss(), *aside], twice) == ["SIGSTOP", "SIGSTOP", "SIGKILL"]
    found = {
        figure.name: figure.value for figure in figures([loss(), *aside], {"controller": HOLDS}, 4)
    }
    assert found["measured"] == 1 and found["controller, SIGKILL: not as documented"] == 0
    assert found["set aside and repeated, other work on the machine"] == 2
    assert found["set aside and repeated, motion at its end"] == 1


def test_a_short_run_is_written_aside_from_the_losses_on_file(tmp_path, monkeypatch):
    on_file = RESULTS / "safety" / "losses.json"
    place, aside = tmp_path / "results", tmp_path / "aside"
    (place / "safety").mkdir(parents=True)
    copy = place / "safety" / "losses.json"
    copy.write_bytes(on_file.read_bytes())
    monkeypatch.setattr(resumable, "PLACE", place)
    monkeypatch.setattr("bench.__main__.PLACE", place)  # no page is written
    monkeypatch.setattr(resumable, "ASIDE", aside)
    monkeypatch.setattr(support.figures, "RESULTS", RESULTS)
    monkeypatch.setattr(support.figures, "ROOT", tmp_path)
    monkeypatch.delenv("FORCE", raising=False)
    monkeypatch.setattr(Part, "measure", lambda _: figures([loss()], {"controller": HOLDS}, 1000))
    assert main(["safety.losses"]) == 0
    assert copy.read_bytes() == on_file.read_bytes()
    (new,) = (aside / "safety").iterdir()
    first = json.loads(new.read_text())["figures"][0]
    assert (new.name, first["name"], first["value"]) == ("losses.json", "measured", 1)
