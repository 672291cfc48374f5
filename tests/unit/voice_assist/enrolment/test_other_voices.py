# SPDX-License-Identifier: BSD-3-Clause
"""Other voices that say the commands: their words are written as those of a take are."""

import numpy as np
import pytest

from voice_assist.enrolment import examples
from voice_assist.recognizer.vocabulary import spelled
from voice_assist.training.data import voices


def test_a_command_is_labelled_as_a_take_of_it(monkeypatch):
    """A digit was left out, so that "preset 1" and "preset 2" were one phrase."""
    phrases = ("preset 1", "preset 2", "x-ray on")
    said = []

    def speak(prompts):
        said.extend(prompt.text for prompt in prompts)
        return [np.zeros(8000, np.int16) for _ in prompts]

    monkeypatch.setattr(examples, "espeak_variants", lambda: (("f1", "m1"), ()))
    monkeypatch.setattr(voices, "speak", speak)
    labels = [example.text for example in examples.other_voices(phrases, 60, seed=1)]
    assert set(phrases) <= set(said)
    assert {"preset one", "preset two", "x ray on"} <= set(labels)
    for text, label in zip(said, labels, strict=True):
        assert (label == spelled(text)) or text not in phrases


@pytest.mark.parametrize(("are_held_out", "expected"), [(False, {"f1", "m1"}), (True, {"f4"})])
def test_the_variants_of_training_are_apart_from_those_that_are_held_out(
    monkeypatch, are_held_out, expected
):
    heard = set()

    def speak(prompts):
        heard.update(prompt.voice.partition("+")[2] for prompt in prompts)
        return [None for _ in prompts]

    monkeypatch.setattr(examples, "espeak_variants", lambda: (["f1", "m1"], ["f4"]))
    monkeypatch.setattr(voices, "speak", speak)
    examples.other_voices(("stop",), 60, seed=1, are_held_out=are_held_out)
    assert heard == expected
