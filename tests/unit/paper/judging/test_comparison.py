# SPDX-License-Identifier: BSD-3-Clause
"""Inputs beside each other."""

import math
from dataclasses import replace

import pytest

from paper.judging.comparison import comparison
from paper.judging.outcomes import PhraseOutcome, keep, kept


def outcome(command="tense", taken=("tense",), refusal="", acted=0.5):
    return PhraseOutcome(command, command, taken, refusal, True, True, 0.2, acted)


def by_name(**inputs):
    """Figures of inputs, each of one voice."""
    return named({name: [outcomes] for name, outcomes in inputs.items()})


def named(inputs):
    return {figure.name: figure for figure in comparison(inputs)}


def test_times_refusals_wrong_and_missed_commands_of_each_input():
    voice = [
        outcome(acted=0.4),
        outcome(acted=0.6),
        outcome("stop", ("stop",), acted=0.1),  # no motion of its own
        outcome("release", (), acted=math.nan),
        outcome("tense", ("release",), acted=math.nan),
        outcome("", ("tense",)),  # talk counts elsewhere
    ]
    pedal = [outcome(acted=0.05), outcome(refusal="nothing is grasped", acted=math.nan)]
    found = by_name(voice=voice, pedal=pedal)
    assert found["voice: time to motion, mean"].value == pytest.approx(0.5)
    mean = found["voice: time to motion, mean"]
    assert (mean.lower, mean.upper) == (None, None)  # of one voice nothing follows for others
    assert "n=2" in mean.note
    assert found["voice: commands missed"].value == pytest.approx(20.0)
    assert found["voice: commands wrong"].value == pytest.approx(20.0)
    assert found["voice: commands refused by the robot"].value == 0.0
    assert found["pedal: time to motion, mean"].value == pytest.approx(0.05)
    assert found["pedal: commands refused by the robot"].value == pytest.approx(50.0)
    assert "wrong presses are not in it" in found["pedal: time to motion, mean"].note


def test_bounds_are_those_of_voices_that_differ():
    missed = outcome(taken=(), acted=math.nan)
    unclear = [outcome(acted=0.6)] * 10 + [missed] * 20
    found = named({"voice": [[outcome(acted=0.4)] * 30, unclear], "pedal": [[outcome()] * 40]})
    lost = found["voice: commands missed"]
    assert (lost.value, lost.note) == (pytest.approx(100 / 3), "20 of 60")
    assert lost.upper == pytest.approx(200 / 3)  # where the second voice is drawn twice
    mean = found["voice: time to motion, mean"]
    assert mean.value == pytest.approx((30 * 0.4 + 10 * 0.6) / 40) and "n=40" in mean.note
    assert (mean.lower, mean.upper) == pytest.approx((0.4, 0.6))
    assert found["pedal: commands missed"].upper == pytest.approx(100 * (1 - 0.05 ** (1 / 40)))


def test_a_voice_that_was_never_heard_has_no_time_and_counts_as_missed():
    silent = [outcome(taken=(), acted=math.nan)] * 5
    found = named({"voice": [[outcome(acted=0.4)] * 5, silent], "pedal": [[outcome()]]})
    mean = found["voice: time to motion, mean"]
    assert (mean.value, mean.lower, mean.upper) == (pytest.approx(0.4), None, None)
    assert found["voice: commands missed"].upper == 100.0


def test_what_was_pressed_or_said_to_go_on_is_compared_with_nothing():
    helped = replace(outcome(refusal="nothing is grasped"), is_counted=False)
    found = by_name(voice=[outcome(), helped], pedal=[outcome(), helped])
    for name in ("voice", "pedal"):
        assert found[f"{name}: commands refused by the robot"].note == "0 of 1"


def test_voice_alone_is_compared_with_nothing():
    assert comparison({"voice": [[outcome()]], "pedal": [[]]}) == []
    assert by_name(voice=[], pedal=[outcome()]).keys() >= {"pedal: commands wrong"}


def test_outcomes_are_kept(tmp_path):
    keep(tmp_path, [outcome()])
    assert kept(tmp_path) == [outcome()]
