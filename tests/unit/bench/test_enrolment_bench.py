# SPDX-License-Identifier: BSD-3-Clause
"""Figures of enrolment: who is among the worst, and when a surgeon is measured anew."""

import pytest

from bench.enrolment import pieces, suite
from bench.enrolment.pieces import Counts, EnrolmentPiece
from session_log.report.bounds import at_most

GOOD, BAD, NONE = Counts(7, 7, 0), Counts(7, 0, 0), Counts(6, 0, 0)


def piece(first, later):
    return EnrolmentPiece("mbrola:de5", 3, first, later, NONE, NONE, GOOD)


def test_the_worst_are_chosen_by_other_clips_than_they_are_judged_by():
    unlucky, hard = piece(BAD, GOOD), piece(GOOD, BAD)
    pairs = [(unlucky, piece(GOOD, GOOD)), *[(hard, piece(GOOD, GOOD))] * 3]
    found = {f.name: f for f in suite._of(3, pairs, [GOOD] * 4)}
    assert found["3 repetitions: worst quarter, base"].value == 0.0
    assert found["3 repetitions: error of all, base"].value == 50.0
    pairs[0] = (piece(BAD, BAD), piece(GOOD, Counts(7, 6, 0)))
    found = {f.name: f for f in suite._of(3, pairs, [GOOD] * 4)}
    assert found["3 repetitions: worst quarter, profile over base"].value == pytest.approx(1 / 7)


def test_the_bound_counts_surgeons():
    counts = [GOOD] * 9 + [BAD]
    figure = suite._share("error", counts)
    assert figure.note == "7 of 70" and figure.upper > 20.0 > 100.0 * at_most(7, 70)


def test_a_change_of_hearing_or_of_a_setting_measures_a_surgeon_anew(monkeypatch):
    monkeypatch.setattr(pieces, "identity", lambda rooms: "other")
    before = pieces.key.__wrapped__()
    monkeypatch.undo()
    assert pieces.key.__wrapped__() != before
    assert {"voice_assist/pipeline", "voice_assist/enrolment.yaml"} <= set(pieces.ENROLMENT)
