# SPDX-License-Identifier: BSD-3-Clause
"""Words become a command in one place."""

from __future__ import annotations

import pytest

from rst_control.commands.parser import read_request
from rst_control.commands.request import Request
from rst_control.commands.table import COMMANDS
from rst_control.types import Reason, Rejected


def test_a_request_carries_the_command_and_its_amounts():
    request = read_request("  Pull   MORE ", tension=0.5, distance=0.002)
    assert request.command is COMMANDS["pull more"]
    assert (request.tension, request.distance) == (0.5, 0.002)


@pytest.mark.parametrize("words", ["", "pull", "tense tense", "don't pull more", "stop it"])
def test_other_words_are_refused_and_the_known_ones_listed(words):
    refusal = read_request(words)
    assert isinstance(refusal, Rejected) and refusal.reason is Reason.UNKNOWN_COMMAND
    assert all(phrase in refusal.words for phrase in COMMANDS)


@pytest.mark.parametrize("amount", [-0.5, float("nan"), float("inf")])
@pytest.mark.parametrize("name", ["tension", "distance"])
def test_amounts_that_make_no_sense_are_refused_and_never_reach_a_planner(name, amount):
    for phrase in ("tense", "pull less", "release"):
        refusal = read_request(phrase, **{name: amount})
        assert isinstance(refusal, Rejected) and refusal.reason is Reason.BAD_AMOUNT
    with pytest.raises(ValueError, match=name):
        Request(COMMANDS["tense"], **{name: amount})


def test_what_moves_nothing_takes_no_amounts():
    request = read_request("hey robot", tension=float("nan"))
    assert (request.tension, request.distance) == (0.0, 0.0)
