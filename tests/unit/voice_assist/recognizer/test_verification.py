# SPDX-License-Identifier: BSD-3-Clause
"""A phrase is verified against other words that the recogniser writes the same."""

import numpy as np
import pytest
import torch

from voice_assist.errors import ModelError
from voice_assist.recognizer.safe_weights import ENCODER_SHA256, STATE
from voice_assist.recognizer.verification import (
    PhraseVerifier,
    read_verifier,
    segments,
    write_verifier,
)
from voice_assist.recognizer.vocabulary import BLANK, encode

WIDTH, BASE = 3, "ab" * 32
PHRASE = "no"
SIZE = (len(PHRASE) + 4) * WIDTH + 1


def path_of(text, time=40, first=10, apart=6):
    """CTC output in which each letter of a text is certain in one frame."""
    logprobs = np.full((time, BLANK + 1), -20.0, np.float32)
    logprobs[:, BLANK] = 0.0
    for index, letter in enumerate(encode(text)):
        logprobs[first + apart * index] = -20.0
        logprobs[first + apart * index, letter] = 0.0
    return logprobs


def test_segments_follow_the_letters_and_then_come_the_sides():
    hidden = np.repeat(np.arange(40, dtype=np.float32)[:, None], WIDTH, axis=1)
    found = segments(hidden, np.array([10, 16])).reshape(-1, WIDTH)
    word = np.arange(6, 21)

    def mean(begin, end):
        return pytest.approx((np.mean(range(begin, end)) - word.mean()) / (1.1 * word.std()), 1e-4)

    assert found.shape == (6, WIDTH)
    sides = [mean(4, 8), mean(17, 20), mean(20, 24), mean(24, 29)]
    assert found[:, 0].tolist() == [mean(8, 13), mean(13, 18), *sides]


@pytest.mark.parametrize("frames", [[0, 1], [38, 39], [0, 39]])
def test_letters_at_the_edges_of_the_sound_take_the_states_that_there_are(frames):
    found = segments(np.ones((40, WIDTH), np.float32), np.array(frames))
    assert found.shape == (6 * WIDTH,) and (found == 0.0).all()


def test_what_is_the_same_in_all_states_matters_little():
    hidden = np.random.default_rng(0).standard_normal((40, WIDTH)).astype(np.float32)
    frames = np.array([10, 16])
    assert segments(5.0 * hidden + 3.0, frames) == pytest.approx(segments(hidden, frames), abs=1e-4)


def test_odds_are_the_weighted_states_and_the_bias():
    weights = np.zeros(SIZE, np.float32)
    weights[0], weights[-1] = 2.0, -5.0
    hidden = np.random.default_rng(0).standard_normal((40, WIDTH)).astype(np.float32)
    expected = 2.0 * segments(hidden, np.array([10, 16]))[0] - 5.0
    found = PhraseVerifier({PHRASE: weights})(hidden, path_of(PHRASE), PHRASE)
    assert found == pytest.approx(expected)


def test_a_phrase_that_it_does_not_know_is_never_doubted():
    hidden = np.zeros((40, WIDTH), np.float32)
    assert PhraseVerifier({})(hidden, path_of(PHRASE), PHRASE) == float("inf")


def test_a_file_gives_back_what_was_written_but_for_another_recogniser(tmp_path):
    weights = np.arange(SIZE, dtype=np.float32)
    write_verifier({PHRASE: weights}, BASE, tmp_path / "v.pt")
    found = read_verifier(BASE, WIDTH, tmp_path / "v.pt")
    heard = np.ones((40, WIDTH), np.float32), path_of(PHRASE), PHRASE
    assert found(*heard) == PhraseVerifier({PHRASE: weights})(*heard)
    assert read_verifier("cd" * 32, WIDTH, tmp_path / "v.pt") is None


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ([1], "holds no mapping, allowed: encoder_sha256 and state"),
        ({ENCODER_SHA256: BASE}, "holds encoder_sha256, allowed"),
        ({ENCODER_SHA256: BASE, STATE: [1]}, "allowed: tensors by name"),
        ({ENCODER_SHA256: BASE, STATE: {PHRASE: torch.zeros(SIZE - 1)}}, "has the shape"),
        ({ENCODER_SHA256: BASE, STATE: {PHRASE: torch.full((SIZE,), torch.nan)}}, "NaN"),
        ({ENCODER_SHA256: BASE, STATE: {"Nö": torch.zeros(SIZE)}}, "letters a to z"),
        ({ENCODER_SHA256: BASE, STATE: {"": torch.zeros(SIZE)}}, "letters a to z"),
        ({ENCODER_SHA256: BASE, STATE: {1: torch.zeros(SIZE)}}, "1 unknown"),
    ],
)
def test_a_file_that_holds_something_else_is_refused(tmp_path, content, words):
    torch.save(content, tmp_path / "v.pt")
    with pytest.raises(ModelError, match=words):
        read_verifier(BASE, WIDTH, tmp_path / "v.pt")
