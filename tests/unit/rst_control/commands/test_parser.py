# SPDX-License-Identifier: BSD-3-Clause
"""Words become a command in one place."""

import pytest

from rst_control.commands.parser import read_request
from rst_control.commands.request import Request
from rst_control.commands.table import COMMANDS
from rst_control.types import Reason, Rejected


def test_a_request_carries_the_command_and_its_amounts():
    request = read_request("  TENSE ", tension=0.5, distance=0.002)
    assert request.command is COMMANDS["tense"]
    assert (request.tension, request.distance) == (0.5, 0.002)


@pytest.mark.parametrize(
    "words",
    [
        *("", "pull", "tense tense", "don't pull more", "stop it"),
        *("look", "look sideways", "left", "look left right", "don't look left"),
    ],
)
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


@pytest.mark.parametrize(
    ("phrase", "amounts", "said"),
    [
        ("tense", {"tension": -0.5}, 'tension of "tense" must be a number from 0 N up, not -0.5 N'),
        ("release", {"tension": 0.5}, '"release" takes no tension, not 0.5 N'),
        ("look up", {"distance": 0.01}, '"look up" takes no distance, not 0.01 m'),
        ("pull more", {"tension": 0.5, "distance": 0.002}, "takes one step, not 0.5 N, 2 mm"),
        ("pull more 2 mm", {"distance": 0.003}, "2 mm in words and another beside them"),
    ],
)
def test_amounts_beside_the_words_are_refused_with_their_value(phrase, amounts, said):
    refusal = read_request(phrase, **amounts)
    assert refusal.reason is Reason.BAD_AMOUNT
    assert said in refusal.words


def test_what_moves_nothing_passes_over_amounts_beside_the_words():
    request = read_request("hey robot", tension=float("nan"))
    assert (request.tension, request.distance) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("words", "tension", "distance"),
    [
        ("pull more 2 mm", 0.0, 0.002),
        ("Pull  MORE 0.5mm ", 0.0, 0.0005),
        ("pull less 0.01 m", 0.0, 0.01),
        ("pull less 0.5 N", 0.5, 0.0),
        ("tense 1.5 n", 1.5, 0.0),
    ],
)
def test_an_amount_may_stand_behind_the_words(words, tension, distance):
    request = read_request(words)
    assert (request.tension, request.distance) == pytest.approx((tension, distance))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("pull more 2 kg", '"pull more" takes N or mm or m, not 2 kg'),
        ("release 2 mm", '"release" takes no amount, not 2 mm'),
        ("hey robot 2 mm", '"hey robot" takes no amount, not 2 mm'),
        ("pull more 0 mm", 'the distance of "pull more" must be above 0 mm, not 0 mm'),
        ("pull less -0.5 N", 'the tension of "pull less" must be above 0 N, not -0.5 N'),
    ],
)
def test_an_amount_that_a_command_cannot_take_is_refused_by_name(words, said):
    refusal = read_request(words)
    assert (refusal.reason, refusal.words) == (Reason.BAD_AMOUNT, said)


@pytest.mark.parametrize("words", ["pull more 2", "pull more mm", "pull more 2 mm now", "2 mm"])
def test_a_number_without_a_unit_is_no_command(words):
    assert read_request(words).reason is Reason.UNKNOWN_COMMAND


@pytest.mark.parametrize("words", ["stop 2 mm", "Stop 0 kg"])
def test_a_stop_stops_whatever_stands_behind_it(words):
    assert read_request(words).command is COMMANDS["stop"]
