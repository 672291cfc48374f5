# SPDX-License-Identifier: BSD-3-Clause
"""The report of a profile can be read by every JSON reader."""

import json

from voice_assist.config import load_voice_config
from voice_assist.enrolment.report import Effort, as_json
from voice_assist.enrolment.self_check import SelfCheckResult
from voice_assist.enrolment.thresholds import ConfidenceEvidence, expected_errors
from voice_assist.profile.manifest import ACTIVE, FORMAT, Manifest


def refuse(word):
    raise AssertionError(f"{word} is no JSON")


def test_where_no_talk_was_recorded_the_rate_has_no_bound():
    command = load_voice_config().commands.get("tense")
    evidence = ConfidenceEvidence(own=(0.99,), missed=0, against=())
    expected = [expected_errors(command, 0.94, evidence, (), hours) for hours in (0.0, 1.0)]
    facts = {"format": FORMAT, "name": "ada", "created": "", "base_sha256": "0" * 64}
    manifest = Manifest(**facts, state=ACTIVE, why=(), takes=(), files=())
    written = as_json(manifest, SelfCheckResult(expected=expected), (), Effort(1.0, 1.0, 1.0, 1.0))
    read = json.loads(written, parse_constant=refuse)
    bounds = [one["false_per_hour_at_most"] for one in read["expected"]]
    assert bounds[0] is None and bounds[1] > 0.0
