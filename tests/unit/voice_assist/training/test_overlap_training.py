# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest
import torch
from whisper.model import ModelDimensions

from voice_assist.recognizer.checkpoint import Checkpoint
from voice_assist.recognizer.whisper_shapes import whisper_shapes
from voice_assist.spotter.overlap import WINDOW, untrained
from voice_assist.training.data.kokoro import FOREIGN, NATIVE, plan_words
from voice_assist.training.data.noise import Surroundings, build_rooms
from voice_assist.training.data.synthesis import TrainingClip
from voice_assist.training.spotter.overlap_mixture import arrange, draw
from voice_assist.training.spotter.train_overlap import average, freeze, loss_of

DIMS = ModelDimensions(80, 512, 4, 2, 3, 51864, 64, 4, 2, 1)
HELD_OUT = (
    *("am_eric", "am_onyx", "af_nova", "af_river", "bf_lily", "bm_daniel"),
    *("hf_", "hm_", "if_", "im_", "zf_", "zm_"),
    *("af_sky", "am_puck", "bf_emma", "bm_fable", "ef_dora", "jm_kumo"),
)


def tone(frequency, seconds):
    time = np.arange(int(seconds * 16000)) / 16000
    return (8000 * np.sin(2 * np.pi * frequency * time)).astype(np.int16)


def clip(text, frequency):
    return TrainingClip(tone(frequency, 0.4), text, "word", "x")


@pytest.fixture
def material():
    rooms = build_rooms((), np.random.default_rng(0), count=3)
    around = Surroundings((), rooms, (tone(200, 4.0), tone(300, 3.0)))
    word = [clip("stop", 1000)]
    return arrange(word, word, [clip("up", 3000), clip("go", 2500)], [clip("top", 2800)], around)


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
    draw_ = torch.Generator().manual_seed(0)
    shapes = whisper_shapes(DIMS)
    state = {name: 0.1 * torch.randn(shape, generator=draw_) for name, shape in shapes.items()}
    torch.manual_seed(0)
    checkpoint = Checkpoint(DIMS, state, None, "0" * 64)
    network, mean = untrained(checkpoint), untrained(checkpoint)
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
