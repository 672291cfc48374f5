# SPDX-License-Identifier: BSD-3-Clause
"""The verifier's training: who speaks, what is kept, and where the threshold lies."""

import numpy as np
import pytest
import torch

from voice_assist.recognizer.checkpoint import EMBEDDED_PATH, read_checkpoint
from voice_assist.recognizer.embedded import restore
from voice_assist.recognizer.verification import BLOCKS
from voice_assist.training.data import voices
from voice_assist.training.verifier import examples
from voice_assist.training.verifier.examples import PHRASES, Examples, Seen
from voice_assist.training.verifier.train_verifier import (
    LOST,
    fold_of,
    sees_the_same,
    train,
)

WIDTH = 8


def clouds(count=60, apart=6.0):
    """Two kinds that differ in one number, by voices of three engines."""
    rng = np.random.default_rng(3)
    is_said = np.arange(2 * count) < count
    seen = rng.standard_normal((2 * count, WIDTH)).astype(np.float32)
    seen[is_said, 0] += apart
    names = [f"{('espeak', 'flite', 'kokoro')[i % 3]}:{i % 11}" for i in range(2 * count)]
    return Examples(seen, is_said, np.array(names))


def test_the_weights_separate_the_kinds_and_odds_of_nearly_all_said_are_above_zero():
    some = clouds()
    weights, figures = train(some)
    odds = some.seen @ weights[:-1] + weights[-1]
    assert (odds[some.is_said] > 0.0).mean() > 1.0 - 10 * LOST
    assert (odds[~some.is_said] < 0.0).mean() > 0.9
    assert figures["area"] > 0.95 and (figures["said"], figures["other"]) == (60, 60)


def test_a_voice_is_in_one_fold_whatever_its_accent_and_engine():
    said = ("espeak:en-us+Bea", "espeak:fr-fr+Bea", "phonemes:de+Bea", "phonemes:it+Bea")
    assert len({fold_of(voice) for voice in said}) == 1
    assert fold_of("kokoro:af_bella") != fold_of("kokoro:am_echo")


def test_what_was_seen_is_kept(tmp_path):
    found = [Seen(p, np.full(3, float(i)), i == 0, "a:b") for i, p in enumerate(PHRASES)]
    examples.save(found, tmp_path / "kept.npz")
    loaded = examples.load(tmp_path / "kept.npz")
    assert list(loaded) == list(PHRASES)
    assert loaded["release"].seen.tolist() == [[1.0, 1.0, 1.0]]
    assert loaded["tense"].is_said.tolist() == [True]


def test_an_aligner_must_have_the_same_lower_blocks_and_may_differ_above():
    model, other = (restore(read_checkpoint(EMBEDDED_PATH)) for _ in range(2))
    with torch.no_grad():
        other.whisper.encoder.blocks[BLOCKS].mlp_ln.bias += 1.0
        assert sees_the_same(model, other)
        other.whisper.encoder.blocks[BLOCKS - 1].mlp_ln.bias += 1e-3
        assert not sees_the_same(model, other)


@pytest.mark.skipif(not voices.espeak_variants()[0], reason="needs espeak-ng")
def test_no_voice_that_is_held_out_speaks():
    _, held_out = voices.espeak_variants()
    for said in examples.plan(1):
        accent, _, variant = said.prompt.voice.partition("+")
        assert variant not in held_out and accent != voices.HELD_OUT_ACCENT
        assert said.prompt.engine not in ("pico", "mbrola")
