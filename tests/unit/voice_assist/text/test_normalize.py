# SPDX-License-Identifier: BSD-3-Clause
import pytest
from hypothesis import given
from hypothesis import strategies as st

from voice_assist.text.normalize import (
    as_text,
    is_negated,
    normalize,
    spoken_number,
    with_same_words,
)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ""),
        ("  \n", ""),
        ("...", ""),
        ("Hey, Robot!", "hey robot"),
        ("PULL  MORE.", "pull more"),
        ("pull-more", "pull more"),
        ("Don't stop", "do not stop"),
        ("don\u2019t stop", "do not stop"),
        ("dont stop", "do not stop"),
        ("I can't", "i can not"),
        ("it won't", "it will not"),
        ("we're", "we are"),
        ("5 mm", "five mm"),
        ("pull 20 more", "pull twenty more"),
        ("in 1905", "in one thousand nine hundred five"),
        ("caf\u00e9 na\u00efve", "cafe naive"),
        ("\uff33\uff34\uff2f\uff30", "stop"),
        ("o'clock", "oclock"),
        ("stop\u200bnow", "stop now"),
        ("\u0663", "three"),
        ("¡Tira más fuerte!", "tira mas fuerte"),
        ("モットひっぱって。", "も っ と ひ っ ぱ っ て"),
        ("ｶﾞｰｾﾞ", "が ー ぜ"),
        ("組織を離して stop", "組 織 を 離 し て stop"),
    ],
)
def test_text_becomes_plain_words(text, words):
    assert " ".join(normalize(text)) == words


@given(st.text(max_size=60))
def test_words_hold_only_lower_case_letters(text):
    for word in normalize(text):
        assert word.isalpha()
        assert word == word.casefold() or not word.isascii()


@given(st.text(alphabet="abc XYZ'.,-0123", max_size=40))
def test_normalising_twice_changes_nothing(text):
    once = normalize(text)
    assert normalize(" ".join(once)) == once


@pytest.mark.parametrize(
    ("text", "written"),
    [
        ("", ""),
        ("Pull more!", "pull more"),
        ("セッション しゅうりょう", "せっしょんしゅうりょう"),
        ("stop とまれ stop", "stop とまれ stop"),
    ],
)
def test_words_are_written_as_a_person_would(text, written):
    assert as_text(normalize(text)) == written


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("Arretez", "arrêtez"),
        ("¡Tira más fuerte!", "tira más fuerte"),
        ("すとっぷ", "ストップ"),
        ("arrêtez vite", ""),
        ("", ""),
    ],
)
def test_a_text_is_found_by_its_words(text, found):
    assert with_same_words(text, ("arrêtez", "tira más fuerte", "ストップ")) == found


ENGLISH = ("don't", "do not pull", "never", "no", "I cannot", "dont", "without it", "won't")
OTHERS = ("nicht ziehen", "nunca más", "ne pas tirer", "引っ張らないで", "ひっぱるな")
NONE = ("now", "know", "nothing else", "note", "pull more", "knot", "はなして")


@pytest.mark.parametrize("text", [*ENGLISH, *OTHERS, *NONE])
def test_denials_are_noticed_and_words_that_only_look_like_them_are_none(text):
    assert is_negated(normalize(text)) is (text not in NONE)


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (0, "zero"),
        (13, "thirteen"),
        (40, "forty"),
        (99, "ninety nine"),
        (100, "one hundred"),
        (312, "three hundred twelve"),
        (1000, "one thousand"),
        (20_005, "twenty thousand five"),
        (1_000_000, "one zero zero zero zero zero zero"),
    ],
)
def test_numbers_are_spoken(value, words):
    assert spoken_number(value) == words
