# SPDX-License-Identifier: BSD-3-Clause
"""Thresholds of a person: by risk, with bounds that few takes leave wide; and the check itself."""

import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voice_assist.config import load_voice_config
from voice_assist.config.enrolment import load_enrolment_config
from voice_assist.enrolment.self_check import SelfCheckResult, SelfCheckTrial
from voice_assist.enrolment.thresholds import ConfidenceEvidence, choose_threshold, expected_errors
from voice_assist.evaluation.exact_bounds import rate_at_most, share_at_most
from voice_assist.profile.manifest import to_bytes
from voice_assist.profile.thresholds import Setting, Settings, from_bytes, overlay

COMMANDS = load_voice_config().commands
CONFIG = load_enrolment_config()
MOTION, HALT, WAKE = (COMMANDS.get(p) for p in ("pull more", "stop", "hey robot"))
sure = st.lists(st.floats(0.0, 1.0), max_size=6).map(tuple)


@pytest.mark.parametrize(
    ("command", "own", "against", "least"),
    [
        (MOTION, (0.97, 0.98, 0.99), (0.87, 0.2), 0.92),  # above what it was wrongly heard in
        (MOTION, (0.96, 0.98), (0.96,), 0.91),  # not above its own takes
        (HALT, (0.58, 0.9), (), 0.53),
        (HALT, (0.9,), (0.99,), HALT.min_confidence),
        (WAKE, (0.3, 0.8), (), 0.25),
        (WAKE, (0.3, 0.8), (0.9,), WAKE.min_confidence),
    ],
)
def test_a_motion_is_raised_a_halt_lowered_and_what_arms_lowered_where_nothing_spoke_against(
    command, own, against, least
):
    found = choose_threshold(command, ConfidenceEvidence(own, 0, against), 0.05)
    assert found == pytest.approx(least)


@given(own=sure, against=sure)
def test_no_evidence_makes_a_motion_easier_or_a_halt_harder(own, against):
    evidence = ConfidenceEvidence(own, 0, against)
    assert choose_threshold(MOTION, evidence, 0.05) >= MOTION.min_confidence
    assert choose_threshold(HALT, evidence, 0.05) <= HALT.min_confidence


@given(st.floats(0.0, 0.95), st.floats(0.0, 0.95))
def test_no_file_makes_a_motion_easier_or_a_halt_harder(motion, halt):
    wanted = (
        Setting(phrase="pull more", least_confidence=motion),
        Setting(phrase="stop", least_confidence=halt),
    )
    own = overlay(COMMANDS, from_bytes(to_bytes(Settings(commands=wanted))))
    assert own.get("pull more").min_confidence == max(motion, MOTION.min_confidence)
    assert own.get("stop").min_confidence == min(halt, HALT.min_confidence)
    assert own.get("tense") == COMMANDS.get("tense")


def test_misses_count_takes_that_were_not_heard_and_those_below():
    expected = expected_errors(
        MOTION, 0.6, ConfidenceEvidence((0.5, 0.9), 1, (0.8,)), (0.8, 0.3), 0.5
    )
    assert (expected.takes, expected.missed, expected.false) == (3, 2, 1)
    assert expected.miss_at_most == pytest.approx(share_at_most(2, 3))
    assert expected.false_per_hour_at_most == pytest.approx(rate_at_most(1, 0.5))


def trials(n, phrase, base, profile):
    def taken(command):
        return (command,) if command else ()

    return [SelfCheckTrial(phrase, taken(base), taken(profile)) for _ in range(n)]


def good():
    own = [*trials(15, "tense", "tense", "tense"), *trials(6, "tense", "", "tense")]
    others = [*trials(40, "stop", "stop", "stop"), *trials(80, "", "", "")]
    return SelfCheckResult(own=own, talk=trials(4, "", "", ""), others=others)


def test_a_better_profile_that_harms_nobody_passes():
    assert good().problems(CONFIG) == ()


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"own": trials(21, "tense", "tense", "")}, "takes: 0 of 21 right, allowed: at least 21"),
        (
            {"own": trials(3, "pull more", "", "pull less")},
            "takes for another command: 3, allowed: up to 0",
        ),
        ({"talk": trials(1, "", "", "tense")}, "commands taken from talk: 1, allowed: up to 0"),
        (
            {"others": trials(40, "stop", "stop", "")},
            "of 40 commands of other voices lost: 40, allowed: up to 1",
        ),
        (
            {"others": trials(80, "", "", "release")},
            "of 80 near misses and talk of others newly taken: 80, allowed: up to 2",
        ),
        ({"wrong_words": ["takes/0001.wav: wrong word"]}, "takes/0001.wav: wrong word"),
    ],
)
def test_whatever_got_worse_is_named_with_what_was_allowed(change, problem):
    problems = dataclasses.replace(good(), **change).problems(CONFIG)
    assert any(problem in found for found in problems), problems
