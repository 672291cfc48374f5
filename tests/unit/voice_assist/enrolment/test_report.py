# SPDX-License-Identifier: BSD-3-Clause
"""The report of a profile can be read by every JSON reader, and by a person."""

import json

import pytest

from voice_assist.config import load_voice_config
from voice_assist.enrolment.report import Effort, as_json, as_markdown
from voice_assist.enrolment.self_check import SelfCheckResult
from voice_assist.enrolment.thresholds import ConfidenceEvidence, expected_errors
from voice_assist.profile.manifest import ACTIVE, FORMAT, Manifest


def refuse(word):
    raise AssertionError(f"{word} is no JSON")


@pytest.fixture
def facts():
    """Of a profile whose talk was none, and of one who talked for an hour."""
    command = load_voice_config().commands.get("tense")
    evidence = ConfidenceEvidence(own=(0.99,), missed=0, against=())
    expected = [expected_errors(command, 0.94, evidence, (), hours) for hours in (0.0, 1.0)]
    known = {"format": FORMAT, "name": "ada", "created": "", "base_sha256": "0" * 64}
    manifest = Manifest(**known, state=ACTIVE, why=(), takes=(), files=())
    return manifest, SelfCheckResult(expected=expected), (), Effort(1.0, 1.0, 1.0, 1.0)


def test_where_no_talk_was_recorded_the_rate_has_no_bound(facts):
    read = json.loads(as_json(*facts), parse_constant=refuse)
    bounds = [one["false_per_hour_at_most"] for one in read["expected"]]
    assert bounds[0] is None and bounds[1] > 0.0


def test_for_a_reader_a_rate_without_a_bound_is_a_word(facts):
    cells = [line.split(" | ")[-1] for line in as_markdown(*facts).decode().splitlines()[-2:]]
    assert cells == ["unknown |", "3 |"]


def test_a_reader_is_told_that_thresholds_were_set_on_what_is_counted(facts):
    assert "chosen on what is counted here" in as_markdown(*facts).decode()
