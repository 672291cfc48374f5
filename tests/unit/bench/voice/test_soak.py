# SPDX-License-Identifier: BSD-3-Clause
"""The judge of the hour of listening: drift, whose answer is whose, growth and loss."""

import pytest

from bench.voice.soak.judge import (
    SoakResult,
    SpokenCommand,
    TakenCommand,
    answers_to,
    drift,
    figures,
)


def test_drift_is_found_where_there_is_one_and_not_where_there_is_none():
    at = [i / 100 for i in range(100)]
    wobble = [(-1) ** i * 3.0 for i in range(100)]
    slope, width = drift(at, [100.0 + w + 40.0 * t for t, w in zip(at, wobble, strict=True)])
    assert abs(slope - 40.0) < width < 10.0
    slope, width = drift(at, [100.0 + w for w in wobble])
    assert abs(slope) < width


def test_an_answer_belongs_to_the_command_said_just_before_it():
    spoken = [
        SpokenCommand("tense", 9.4, 10.0),
        SpokenCommand("stop", 11.9, 12.5),
        SpokenCommand("tense", 59.4, 60.0),
    ]
    found = answers_to(spoken, [(10.2, "tense"), (12.4, "stop"), (30.0, "tense")])
    assert [(a.text, round(a.latency, 3)) for a in found] == [("tense", 0.2), ("stop", -0.1)]


def test_a_command_said_again_is_answered_by_its_own_match_and_not_by_the_one_before():
    spoken = [
        SpokenCommand("release", 9.5, 10.2),
        SpokenCommand("release", 12.0, 12.7),
        SpokenCommand("release", 14.5, 15.2),
    ]
    found = answers_to(spoken, [(10.4, "release"), (12.95, "release")])
    assert [round(a.latency, 3) for a in found] == [0.2, 0.25]


def test_commands_that_differ_in_latency_are_no_drift():
    answers = [TakenCommand("stop", 60.0 * i, 0.1) for i in range(1, 30)]
    answers += [TakenCommand("tense", 60.0 * i, 0.2) for i in range(30, 60)]
    memory = [(60.0 * i, 4e8) for i in range(1, 61)]
    found = {f.name: f for f in figures(SoakResult(3600, 60, answers, memory, 0, 0, 0.1, 9))}
    assert found["soak: drift of latency"].value == pytest.approx(0.0, abs=1e-9)


def test_a_soak_that_grows_or_loses_sound_misses_its_targets():
    answers = [TakenCommand("stop", 60.0 * i, 0.2) for i in range(1, 60)]
    steady = [(60.0 * i, 4e8) for i in range(1, 61)]
    growing = [(60.0 * i, 4e8 + 1e6 * i) for i in range(1, 61)]
    met = {f.name: f.is_met for f in figures(SoakResult(3600, 60, answers, steady, 0, 0, 0.1, 9))}
    assert met["soak: memory grown"]
    assert met["soak: lost samples"]
    met = {f.name: f.is_met for f in figures(SoakResult(3600, 60, answers, growing, 5, 0, 0.1, 9))}
    assert not met["soak: memory grown"]
    assert not met["soak: lost samples"]
