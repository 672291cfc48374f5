# SPDX-License-Identifier: BSD-3-Clause
import pytest

from voice_assist.evaluation.evaluator import ClipOutcome, LabelledClip, Taken
from voice_assist.evaluation.metrics import summarize, verdict


def outcome(phrase, *commands):
    taken = tuple(Taken(c, 0.1 * (i + 1), 0.9) for i, c in enumerate(commands))
    return ClipOutcome(LabelledClip(2, None, phrase, phrase), 36.0, taken, (), (), 0.5, 37.0)


def test_a_wrong_command_beside_the_right_one_is_a_confusion():
    assert verdict(outcome("tense", "tense")) == "correct"
    assert verdict(outcome("tense", "tense", "tense")) == "correct"
    assert verdict(outcome("tense", "tense", "stop")) == "stop"
    assert verdict(outcome("tense")) == "rejected"


def test_false_commands_are_counted_per_hour_and_rates_of_nothing_are_none():
    negatives = summarize([outcome("", "stop", "tense"), outcome("")], ("stop",))["negatives"]
    assert negatives["hours"] == pytest.approx(0.02)
    assert negatives["accepted_per_hour"] == pytest.approx(100.0)
    figures = summarize([], ("stop",))
    assert figures["accuracy"] is figures["real_time_factor"] is None
    assert figures["negatives"]["accepted_per_hour"] is None


def test_percentiles_are_those_of_the_clips():
    said = LabelledClip(2, None, "stop", "stop")
    taken = [(Taken("stop", i / 1e3, 1.0),) for i in range(101)]
    outcomes = [ClipOutcome(said, 1.0, one, (), (), 0, 1) for one in taken]
    latency = summarize(outcomes, ("stop",))["latency_ms"]["stop"]
    assert latency == pytest.approx({"p50": 50.0, "p95": 95.0, "p99": 99.0})
