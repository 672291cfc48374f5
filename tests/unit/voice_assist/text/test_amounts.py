# SPDX-License-Identifier: BSD-3-Clause
"""Numbers and units in words."""

import pytest

from voice_assist.text.amounts import (
    amount_words,
    canonical,
    in_digits,
    spoken_amount,
    value_of,
    with_value,
)
from voice_assist.text.normalize import normalize


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("two", 2.0),
        ("to", 2.0),
        ("twenty two", 22.0),
        ("half", 0.5),
        ("a half", 0.5),
        ("two and a half", 2.5),
        ("one point five", 1.5),
        ("point two five", 0.25),
        ("one point oh five", 1.05),
        ("one point to", 1.2),
        ("point", None),
        ("point ten", None),
        ("two three", None),
        ("more", None),
        ("", None),
    ],
)
def test_words_become_a_number_or_none(text, value):
    assert value_of(tuple(text.split())) == value


@pytest.mark.parametrize(
    "thousandths", [1, 20, 200, 250, 500, 999, 1000, 1500, 2000, 22000, 999000]
)
def test_every_amount_is_read_as_it_is_spoken(thousandths):
    value = thousandths / 1000
    for unit in ("mm", "N"):
        said = tuple(spoken_amount(value, unit).split())
        assert canonical(said) == said
        number = said[:1] if value == 0.5 else said[:-1]
        assert value_of(number) == value


@pytest.mark.parametrize(
    ("text", "known_as"),
    [
        ("Pull 2mm more.", "pull two millimetres more"),
        ("pull 0.5 mm more", "pull half a millimetre more"),
        ("pull zero point five millimeters more", "pull half a millimetre more"),
        ("pull to mill more", "pull two millimetres more"),
        ("pull 1 millimeter less", "pull one millimetre less"),
        ("half an N less", "half a newton less"),
        ("tension 1.5 newton", "tension one point five newtons"),
        ("pull one hundred two three mm", "pull one hundred two three mm"),
        ("pull two more", "pull two more"),
        ("pull two metres more", "pull two metres more"),
        ("it goes to the left", "it goes to the left"),
    ],
)
def test_an_amount_is_known_by_one_wording(text, known_as):
    assert " ".join(canonical(normalize(text))) == known_as


def test_numbers_and_units_are_found_among_other_words():
    words = normalize("pull twenty two kg or 0.5 newtons more")
    assert amount_words(words) == ("twenty", "two", "kg", "zero", "point", "five", "newtons")


@pytest.mark.parametrize(
    ("text", "value", "other"),
    [
        ("pull two mm more", 10.0, "pull ten mm more"),
        ("pull two millimetres more", 1.0, "pull one millimetre more"),
        ("pull one millimetre more", 0.5, "pull half a millimetre more"),
        ("tension one point five", 2.0, "tension two point zero"),
        ("pull more", 2.0, "pull more"),
    ],
)
def test_another_number_is_put_as_it_would_have_been_heard(text, value, other):
    assert " ".join(with_value(tuple(text.split()), value)) == other


def test_a_text_with_digits_is_how_large_models_write_it():
    assert in_digits(normalize("pull two mm more")) == "pull 2 mm more"
    assert in_digits(normalize("half a newton less")) == "0.5 newton less"
