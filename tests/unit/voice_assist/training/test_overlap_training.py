# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest
import torch

from tests.unit.voice_assist.support.small_recognizer import spotter_material, tiny_checkpoint
from voice_assist.spotter.overlap import WINDOW, untrained
from voice_assist.training.data.kokoro import FOREIGN, NATIVE, plan_words
from voice_assist.training.spotter.overlap_mixture import draw
from voice_assist.training.spotter.train_overlap import average, freeze, loss_of

HELD_OUT = (
    *("am_eric", "am_onyx", "af_nova", "af_river", "bf_lily", "bm_daniel"),
    *("hf_", "hm_", "if_", "im_", "zf_", "zm_"),
    *("af_sky", "am_puck", "bf_emma", "bm_fable", "ef_dora", "jm_kumo"),
)


@pytest.fixture
def material():
    return spotter_material()


def test_the_same_seed_draws_the_same_windows(material):
    one, other = (draw(material, 16, np.random.default_rng(3)) for _ in range(2))
    np.testing.assert_array_equal(one.sound, other.sound)
    np.testing.assert_array_equal(one.is_word, other.is_word)
    assert one.sound.shape == (16, WINDOW)
    assert np.isfinite(one.sound).all()
    assert np.abs(one.sound).max() <= 1.0


def test_the_word_is_in_its_frames_and_ends_near_the_end_of_the_window(material):
    batch = draw(material, 64, np.random.default_rng(4))
    assert 20 < batch.is_word.sum() < 44
    for frames in batch.frames[batch.is_word == 1]:
        last = int(np.flatnonzero(frames)[-1])
        assert 0.0 <= (len(frames) - 1 - last) * 0.02 <= 0.42
        assert 15 <= frames.sum() <= 26


def test_only_the_last_blocks_and_the_head_are_trained(material):
    torch.manual_seed(0)
    network, mean = (untrained(tiny_checkpoint()) for _ in range(2))
    freeze(network)
    loss_of(network, draw(material, 4, np.random.default_rng(5))).backward()
    moved = {name for name, w in network.named_parameters() if w.grad is not None}
    assert moved == network.own_state().keys()
    average(mean, network, 1)
    for name, weight in mean.own_state().items():
        assert torch.isfinite(weight).all(), name


def test_no_held_out_voice_of_kokoro_speaks():
    assert not [v for v in (*NATIVE, *FOREIGN) if v.startswith(HELD_OUT)]
    prompts = plan_words()
    assert {p.voice for p in prompts if p.text == "stop"} == {*NATIVE, *FOREIGN}
    assert all(p.sounds.endswith(".") for p in prompts)
