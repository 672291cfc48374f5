# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest
import torch

from tests.unit.voice_assist.support.fake_speech import frames
from tests.unit.voice_assist.support.small_recognizer import TINY, tiny_checkpoint
from voice_assist.config import load_voice_config
from voice_assist.errors import ModelError
from voice_assist.recognizer.checkpoint import read_checkpoint
from voice_assist.spotter.overlap import (
    STEADY,
    STEP,
    WINDOW,
    SoundScorer,
    WindowCutter,
    is_steady,
    overlap_scorer,
    read_overlap,
    untrained,
    write_overlap,
)
from voice_assist.spotter.spotter import Spotter
from voice_assist.types import RATE

CONFIG = load_voice_config().spotter


@pytest.fixture(scope="module")
def encoder(tmp_path_factory):
    """A small recogniser of random weights."""
    path = tmp_path_factory.mktemp("encoder") / "encoder.pt"
    torch.save({"dims": vars(TINY), "model_state_dict": tiny_checkpoint().state}, path)
    return path


@pytest.fixture
def written(encoder, tmp_path):
    """A spotter's file, and the network in it."""
    checkpoint = read_checkpoint(encoder)
    torch.manual_seed(0)
    network = untrained(checkpoint).eval()
    path = tmp_path / "overlap.pt"
    write_overlap(network, checkpoint.sha256, path)
    return path, network


def talk(seconds):
    return np.random.default_rng(1).uniform(-0.1, 0.1, round(seconds * RATE)).astype(np.float32)


def word_in_noise():
    """What is in the middle of a window is as loud as the noise around it."""
    window, other = np.split(talk(3.2), 2)
    window[9000:14000] += 2.0 * other[9000:14000] * np.hanning(5000).astype(np.float32)
    return window


@pytest.mark.parametrize("block", [1, 512, STEP, 5000])
def test_windows_do_not_depend_on_the_blocks_they_come_in(block):
    sound, cutter = talk(0.5 if block == 1 else 2.0), WindowCutter()
    seen = [w for at in range(0, len(sound), block) for w in cutter(sound[at : at + block])]
    assert len(seen) == len(sound) // STEP
    padded = np.concatenate([np.zeros(WINDOW, np.float32), sound])
    for number, window in enumerate(seen, 1):
        np.testing.assert_array_equal(window, padded[number * STEP :][:WINDOW])


def test_a_new_stream_begins_in_silence():
    cutter = WindowCutter()
    first = list(cutter(talk(1.0)))
    cutter.reset()
    for one, other in zip(first, cutter(talk(1.0)), strict=True):
        np.testing.assert_array_equal(one, other)


def test_steady_sound_costs_no_pass_and_a_word_as_loud_as_the_noise_does(written):
    _, network = written
    noise = talk(1.6)
    assert is_steady(noise) and is_steady(np.zeros(WINDOW, np.float32))
    assert overlap_scorer(network)(noise[None]) == STEADY
    word = word_in_noise()
    assert not is_steady(word)
    assert overlap_scorer(network)(word[None]) != STEADY


@pytest.mark.parametrize("offset", [-0.03, 0.01, 0.3])
def test_a_word_stands_out_whatever_the_offset_of_the_card(offset):
    shift, quiet = np.float32(offset), np.float32(0.05)
    assert not is_steady(quiet * word_in_noise() + shift)
    assert is_steady(quiet * talk(1.6) + shift)
    assert is_steady(np.full(WINDOW, shift))


def test_what_is_written_is_read_and_judges_alike(written, encoder):
    path, network = written
    read, digest = read_overlap(path, encoder)
    assert len(digest) == 64
    window = word_in_noise()[None]
    assert overlap_scorer(read)(window) == pytest.approx(overlap_scorer(network)(window), abs=0.01)


def test_the_file_holds_no_weight_of_the_frozen_encoder(written):
    path, _ = written
    state = torch.load(path, weights_only=True)["state"]
    blocks = {name.split(".")[2] for name in state if name.startswith("encoder.blocks")}
    assert blocks == {"1", "2"}
    assert all(weight.dtype == torch.float16 for weight in state.values())


def test_another_encoder_is_refused(written, encoder):
    path, network = written
    write_overlap(network, "0" * 64, path)
    with pytest.raises(ModelError, match=r"belongs to the encoder 000"):
        read_overlap(path, encoder)


def test_it_fires_once_for_a_word_and_again_after_a_second():
    times = {10, 11, 12, 13, 30, 31}  # windows that are sure

    def score(windows):
        assert windows.shape == (1, WINDOW)
        score.calls += 1
        return 12.0 if score.calls in times else -12.0

    score.calls = 0
    spotter = Spotter(CONFIG, WindowCutter(), score, 1)
    fired = [found for frame in frames(talk(3.2)) if (found := spotter(frame))]
    assert len(fired) == 2
    assert fired[1].time - fired[0].time > CONFIG.rearm_after


class Loudest:
    """A network whose answer is the loudest sample of a window; counts the windows."""

    asked = 0

    def __call__(self, windows):
        assert windows.shape[1] == WINDOW
        self.asked += len(windows)
        return windows.max(1).values, windows


@pytest.mark.parametrize("block", [512, 5_000, 160_000])
@pytest.mark.parametrize("place", [0.0, 0.4, 0.999])
def test_a_sound_that_grows_is_heard_whole_and_each_part_once(block, place):
    network = Loudest()
    scorer, sound = SoundScorer(network), np.zeros(80_000, np.float32)
    sound[int(place * len(sound))] = 1.0
    for until in range(block, len(sound) + 1, block):
        scorer.follow(sound[:until])
    assert scorer.best(sound, 0.0) == 1.0
    assert network.asked <= len(sound) / 3_840 + 1


def test_a_window_in_the_quiet_after_the_last_word_is_asked_about_once():
    network = Loudest()
    scorer, sound = SoundScorer(network), np.zeros(32_000, np.float32)
    scorer.follow(sound[:8_000])
    assert network.asked == 2  # the second window ended with 7,680 samples
    scorer.best(sound[:8_480], 0.05)  # so did the word, at the latest
    assert network.asked == 2
    scorer.best(sound[:9_000], 0.05)  # the quiet began after that window
    scorer.best(sound[:10_000], 0.1125)
    assert network.asked == 3
    sound[10_100] = 1.0
    assert scorer.best(sound[:11_000], 0.0) == 1.0


def test_what_was_said_before_a_restart_counts_no_more():
    scorer, sound = SoundScorer(Loudest()), np.zeros(16_000, np.float32)
    assert scorer.best(sound + 1.0, 0.0) == 1.0
    scorer.restart()
    assert scorer.best(sound, 0.0) == 0.0


@pytest.mark.parametrize("seconds", [0.0, 0.3, 1.0, 3.0])
@pytest.mark.parametrize("place", [0.0, 0.5, 1.0])
def test_the_newest_second_of_a_sound_is_seen_whole(seconds, place):
    sound = np.zeros(round(seconds * 16_000), np.float32)
    newest = sound[-16_000:]
    if len(newest):
        newest[min(round(place * len(newest)), len(newest) - 1)] = 1.0
    assert SoundScorer(Loudest()).newest(sound) == (1.0 if len(newest) else 0.0)
