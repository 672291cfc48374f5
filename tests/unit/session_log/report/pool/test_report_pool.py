# SPDX-License-Identifier: BSD-3-Clause
"""Summaries of sessions and what they add up to."""

import json
import math
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

from session_log.report.pool.pool import Pool, reason_of
from session_log.report.sections import large_facts
from session_log.report.session.analysis import command_rows, rcm_while_moving, statistics
from session_log.report.session.shaft import rcm_from_joints
from session_log.report.session.summary import (
    GivenCommand,
    MomentSummary,
    from_json,
    moments,
    summarise,
)
from session_log.report.session.trials import NO_COMMAND, NOT_SAID, NOTHING, OTHER, PhraseTrial
from session_log.report.tables import pool_tables


@pytest.fixture(scope="module")
def summary(data, report_config):
    rows, rcm = command_rows(data, report_config), rcm_from_joints(data, report_config)
    return summarise("story", data, rows, rcm, report_config)


def pool_of(config, *summaries):
    pool = Pool(config)
    for k, summary in enumerate(summaries):
        pool.add(Path(f"{k}.mcap"), None, summary)
    return pool


def given(command="tense", reaction=math.nan, by="voice", decided=0.1, **more):
    fields = {"outcome": "accepted", "message": "", "is_partial": False, **more}
    return GivenCommand(command, decided, reaction, given_by=by, **fields)


def changed(summary, *pairs, **fields):
    found = tuple(PhraseTrial(float(k), meant, taken, "") for k, (meant, taken) in enumerate(pairs))
    return replace(summary, trials=found, **fields)


def test_a_summary_says_what_the_session_says(summary, data):
    moving = statistics(rcm_while_moving(data))
    assert (summary.rcm.count, summary.rcm.largest) == (moving.count, moving.largest)
    assert summary.rcm.rms == pytest.approx(moving.rms)
    assert summary.tension == pytest.approx(2.0, abs=0.05)
    assert summary.ignored == 2 and summary.is_complete and summary.commit.startswith("0123456789")
    assert len(summary.given) == 11 and sum(g.outcome == "refused" for g in summary.given) == 1


def test_a_summary_survives_its_file(summary):
    odd = replace(summary, margin=math.nan)
    text = json.dumps(asdict(odd))
    again = from_json(json.loads(text))
    assert json.dumps(asdict(again)) == text and len(text) < 8000
    assert math.isnan(again.margin) and again.trials == summary.trials


def test_something_else_is_no_summary(summary):
    values = asdict(summary)
    with pytest.raises((TypeError, KeyError)):
        from_json({**values, "unknown": 1})
    del values["trials"]
    with pytest.raises((TypeError, KeyError)):
        from_json(values)


def test_joined_moments_are_those_of_all_numbers():
    rng = np.random.default_rng(5)
    parts = [rng.normal(size=n) for n in (1, 17, 200)]
    parts.append(np.array([math.nan]))
    joined = sum(map(moments, parts), MomentSummary())
    every = moments(np.concatenate(parts))
    assert (joined.count, joined.largest) == (every.count, every.largest) == (218, joined.largest)
    assert joined.rms == pytest.approx(every.rms) and math.isnan(MomentSummary().rms)


def test_software_versions_are_counted(summary, report_config):
    pool = pool_of(report_config, summary, replace(summary, commit="ffff"), summary)
    assert pool.commits == {summary.commit: 2, "ffff": 1}


def test_the_order_of_sessions_does_not_matter(summary, report_config):
    other = changed(summary, ("stop", NOTHING), ("tense", "stop"), started=1.0)
    third = replace(summary, started=2.0, given=summary.given[:3])
    texts = []
    for order in ((summary, other, third), (third, summary, other)):
        pool = pool_of(report_config, *order)
        made = (
            pool_tables.accuracy_table,
            pool_tables.confusion_table,
            pool_tables.latency_table,
            pool_tables.motion_table,
        )
        texts.append([make(pool).rows for make in made])
        starts = [m.started for m in pool.sorted_members()]
        assert starts == sorted(starts)
    assert texts[0] == texts[1]


def test_accuracy_counts_commands_apart_from_words_that_are_none(summary, report_config):
    pairs = [("tense", "tense"), ("tense", OTHER), ("stop", "tense"), (NO_COMMAND, OTHER)]
    pairs += [(NO_COMMAND, "stop"), (NOT_SAID, "stop")]
    pool = pool_of(report_config, changed(summary, *pairs))
    assert pool.accuracy("tense")[:2] == (1, 2)
    assert pool.accuracy("stop")[:2] == (0, 1)
    assert pool.accuracy()[:2] == (1, 3)
    assert pool.accuracy(NO_COMMAND)[:2] == (1, 2)
    assert pool.accuracy("release")[:2] == (0, 0)
    rows, columns, counts = pool_tables.confusion_counts(pool)
    assert rows == ["tense", "stop", NO_COMMAND, NOT_SAID]
    assert columns == ["tense", "stop", OTHER, NOTHING]
    assert counts == [[1, 0, 1, 0], [1, 0, 0, 0], [0, 1, 1, 0], [0, 1, 0, 0]]


def test_latency_stands_beside_the_paper_with_bounds_where_there_are_values(summary, report_config):
    many = tuple(given("tense", 0.01 * k) for k in range(1, 101))
    few = (given("stop", 0.3), given("stop", 0.5), given("release"))
    by_hand = (given(by="hand", decided=math.nan),)
    pool = pool_of(report_config, replace(summary, given=(*many, *few, *by_hand)))
    rows = {row[0]: row[1:] for row in pool_tables.latency_table(pool).rows}
    assert rows["tense"][:3] == ("100", "0.10", "0.51")
    assert rows["tense"][3:] == ("0.51 (0.40 to 0.61)", "0.95 (0.90 to 1.00)", "1.14")
    assert rows["stop"] == ("2", "0.10", "0.40", "0.40", "0.49", "1.29")
    assert rows["release"] == ("0", "0.10", "–", "–", "–", "1.42")
    assert rows["all"][0] == "102" and rows["all"][-1] == "1.75"


def test_voice_and_pedal_stand_beside_each_other_with_their_bounds(summary, report_config):
    spoken = [*(given(reaction=0.3 + 0.01 * k) for k in range(9)), given(outcome="refused")]
    pressed = [given(reaction=0.02, by="pedal", decided=math.nan)]
    said = changed(summary, ("tense", "tense"), ("stop", "tense"), ("tense", NOTHING))
    pool = pool_of(report_config, replace(said, given=(*pressed, *spoken)))
    assert pool_tables.inputs_table(pool).rows == [
        (
            "voice",
            "10",
            "1 (0.3 to 44.5\u00a0%)",
            "1 (0.8 to 90.6\u00a0%)",
            "0.34 (0.31 to 0.37)",
            "0.38",
        ),
        ("pedal", "1", "0 (0.0 to 97.5\u00a0%)", "–", "0.02", "0.02"),
    ]


def test_a_command_unknown_to_the_paper_has_a_row_without_its_figure(summary, report_config):
    pool = pool_of(report_config, replace(summary, given=(given("wave", 0.2),)))
    rows = {row[0]: row for row in pool_tables.latency_table(pool).rows}
    assert rows["wave"] == ("wave", "1", "0.10", "0.20", "0.20", "0.20", "–")


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        ('in standby; say "hey robot" first', "in standby"),
        ("tension limit: 2.25 N asked for, allowed 2.00 N", "tension limit"),
        ("joint_4 at 2.571 rad", "joint_… at … rad"),
        ("", "no reason given"),
    ],
)
def test_refusals_are_counted_by_their_kind(message, reason):
    assert reason_of(message) == reason


def test_refusals_of_many_sessions_are_counted_most_frequent_first(summary, report_config):
    asked = (("tense", "halted; say"), ("stop", "x"), ("tense", "halted"))
    refused = [given(command, outcome="refused", message=words) for command, words in asked]
    pool = pool_of(report_config, replace(summary, given=tuple(refused)))
    assert pool_tables.reasons_table(pool.refusals).rows == [
        ("tense", "halted", "2"),
        ("stop", "x", "1"),
    ]


def test_the_facts_count_refusals_among_the_commands_beside_them(summary, report_config):
    away = {"message": "/light, away"}
    mixed = [given(outcome=outcome, **away) for outcome in ("accepted", "refused", "failed")]
    mixed += [given(by="pedal", outcome="refused", **away)] * 4
    pool = pool_of(report_config, replace(summary, given=tuple(mixed)))
    spoken = pool.inputs["voice"]
    assert (spoken.given, spoken.refused) == (3, 1) and pool.outcomes["refused"] == 5
    facts = large_facts(pool, {"spoken commands": spoken.given, "refused": spoken.refused})
    assert list(facts.items())[:3] == [
        ("spoken commands", "3"),
        ("refused", "1"),
        ("device calls that failed", "1"),
    ]
    assert pool_tables.reasons_table(pool.failures).rows == [("tense", "/light, away", "1")]
    assert "device calls that failed" not in large_facts(pool_of(report_config, summary), {})


def test_the_largest_tension_stands_beside_that_with_a_target(summary, report_config):
    unmeasured = replace(summary, tension=math.nan, tension_with_target=math.nan)
    halted = replace(unmeasured, tension=2.6)
    pool = pool_of(report_config, unmeasured, summary, halted, unmeasured)
    assert large_facts(pool, {})["largest tension"] == "2.60\u00a0N"
    rows = {row[0]: row[2] for row in pool_tables.motion_table(pool).rows}
    assert rows["tension"] == "2.60\u00a0N"
    assert rows["tension with a target set"] == f"{summary.tension_with_target:.2f}\u00a0N"
    assert "largest tension" not in large_facts(pool_of(report_config, unmeasured), {})


def test_a_pool_keeps_numbers_not_sessions(summary, report_config):
    """A thousand sessions must not weigh more than their rows and latencies."""
    pool = pool_of(report_config, summary, summary)
    assert not any(isinstance(v, tuple) and v for v in vars(pool.members[0]).values())
    assert len(pool.latencies().decision) == 22


@pytest.mark.parametrize(
    ("changes", "is_complete"),
    [
        ({}, True),
        ({"checksum": "none"}, True),  # of another recorder
        ({"checksum": "wrong"}, False),
        ({"is_closed": False}, False),
        ({"metadata": [("losses", {"/t from /p": "3 dropped, 0 missed"})]}, False),
        ({"metadata": [("losses", {"/t from /p": "0 dropped, 2 missed"})]}, True),
        ({"metadata": [("recovered", {"was_closed": "False"})]}, False),
        ({"metadata": [("recovered", {"was_closed": "True"})]}, True),
    ],
)
def test_a_session_is_complete_where_nothing_was_lost_or_changed(
    data, report_config, changes, is_complete
):
    recording = replace(data.recording, condition=replace(data.recording.condition, **changes))
    rcm = rcm_from_joints(data, report_config)
    found = summarise("s", replace(data, recording=recording), [], rcm, report_config)
    assert found.is_complete is is_complete
