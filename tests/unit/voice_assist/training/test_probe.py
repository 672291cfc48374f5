"""The probe: what can be told apart, and that words and voices give nothing away."""

import numpy as np
import pytest

from voice_assist.training import probe
from voice_assist.training.data.synthesis import Clip


def groups(count, size):
    return [f"voice{index}" for index in range(count) for _ in range(size)]


def test_a_clear_difference_is_found():
    rng = np.random.default_rng(1)
    labels = np.arange(200) % 40 < 20  # whole voices of five are of one kind
    features = rng.normal(0, 1, (200, 6)).astype(np.float32)
    features[labels, 2] += 4.0
    assert probe.separability(features, labels, groups(40, 5)) > 0.95


def test_no_difference_is_no_difference_however_many_features():
    rng = np.random.default_rng(2)
    features = rng.normal(0, 1, (400, 100)).astype(np.float32)
    labels = rng.random(400) < 0.5
    assert probe.separability(features, labels, groups(80, 5)) == pytest.approx(0.5, abs=0.1)


def test_what_only_marks_a_voice_does_not_count():
    rng = np.random.default_rng(3)
    voice = np.repeat(np.arange(60), 6)
    labels = (rng.random(60) < 0.5)[voice]
    features = np.eye(60, dtype=np.float32)[voice]  # each voice its own mark, learnt in vain
    area = probe.separability(features, labels, [f"v{number}" for number in voice])
    assert area < 0.65


def test_both_sides_say_the_same_words_equally_often():
    def clip(text, kind):
        return Clip(np.ones(10, np.int16), text, kind, "a")

    one = [clip("stop", "span")] * 5 + [clip("go", "span")] * 2
    other = [clip("stop", "word")] * 3 + [clip("go", "word")] * 9
    kept = probe.evenly(one, other, np.random.default_rng(0))
    said = [(c.text, c.kind) for c in kept]
    assert {pair: said.count(pair) for pair in set(said)} == {
        **{("stop", "span"): 3, ("stop", "word"): 3},
        **{("go", "span"): 2, ("go", "word"): 2},
    }


def test_clips_are_heard_in_one_second_at_one_level():
    for samples in (
        np.full(100, 50, np.int16),
        np.full(40000, -9, np.int16),
        np.zeros(9, np.int16),
    ):
        placed = probe.centred(samples)
        assert placed.shape == (probe.LENGTH,)
        assert np.abs(placed).max() == pytest.approx(0.3 if samples.any() else 0.0)
