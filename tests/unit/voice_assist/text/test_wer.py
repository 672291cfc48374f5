# SPDX-License-Identifier: BSD-3-Clause
import jiwer
import pytest
from hypothesis import given
from hypothesis import strategies as st

from voice_assist.text.wer import distance, min_distance, wer

SENTENCES = st.lists(st.sampled_from(["pull", "more", "less", "stop"]), max_size=6)


@pytest.mark.parametrize(
    ("reference", "heard", "rate"),
    [
        ("pull more", "pull more", 0.0),
        ("pull more", "pull less", 0.5),
        ("pull more", "pull", 0.5),
        ("pull more", "", 1.0),
        ("stop", "stop stop stop", 2.0),
        ("tense", "tents", 1.0),
        ("", "", 0.0),
        ("", "thank you", 2.0),
    ],
)
def test_rate_counts_errors_per_word_of_the_reference(reference, heard, rate):
    assert wer(reference.split(), heard.split()) == rate


@given(SENTENCES.filter(len), SENTENCES)
def test_rate_agrees_with_an_independent_implementation(reference, heard):
    assert wer(reference, heard) == pytest.approx(jiwer.wer(" ".join(reference), " ".join(heard)))


def test_no_continuation_is_nearer_than_the_min_distance():
    spoken = ["pull", "less"]
    for beginning in ([], ["pull"], ["the"], ["less"], ["pull", "the", "less"]):
        least = min_distance(spoken, beginning)
        rests = [[], ["less"], ["pull", "less"], ["pull"], ["more", "less"]]
        assert least == min(distance(spoken, [*beginning, *rest]) for rest in rests)
