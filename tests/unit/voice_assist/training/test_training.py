# SPDX-License-Identifier: BSD-3-Clause
"""Training: items, batches, steps, resuming, the learning rate and the split of voices."""

import ast

import numpy as np
import pytest
import torch

from tests.unit.voice_assist.support.small_recognizer import SMALL, small_model, sound
from typed_config import package_folder
from voice_assist.recognizer.hybrid import WhisperCtc
from voice_assist.training.data import batches as batches_of_pools
from voice_assist.training.data import synthesis, texts, voices
from voice_assist.training.data.augment import Strength, telephone
from voice_assist.training.data.batches import Batches
from voice_assist.training.data.mixture import Aligned, Mixture, WordTime, cut_short, excerpt
from voice_assist.training.data.noise import Surroundings, build_rooms
from voice_assist.training.data.synthesis import (
    SynthesisAmounts,
    TrainingClip,
    plan_held_out,
    plan_training,
)
from voice_assist.training.fit.checkpoints import Average, Progress, load_progress, save_progress
from voice_assist.training.fit.curriculum import SHORT
from voice_assist.training.fit.objective import joint_loss
from voice_assist.training.fit.train_recognizer import Schedule


@pytest.fixture(scope="module")
def model():
    return small_model()


def clip(text, seconds=1.0, kind="command", speaker="a"):
    return TrainingClip((sound(seconds) * 32767).astype(np.int16), text, kind, speaker)


WORDS = ("snowing", "table", "stop", "garden")
ALIGNED = Aligned(
    clip("pull more now", 1.5, "sentence"),
    (WordTime("pull", 0.1, 0.4), WordTime("more", 0.5, 0.8), WordTime("now", 1.0, 1.3)),
)


def test_excerpt_holds_its_words_and_half_of_the_gaps():
    part = excerpt(ALIGNED, 1, 2)
    assert part.clip.text == "more"
    assert part.words == (WordTime("more", pytest.approx(0.05), pytest.approx(0.35)),)
    assert len(part.clip.samples) == pytest.approx((0.9 - 0.45) * 16000, abs=2)


def test_sound_cut_short_is_written_as_the_part_heard():
    rng = np.random.default_rng(0)
    for _ in range(50):
        item = cut_short(ALIGNED, rng)
        assert "pull more now".startswith(item.text)
        if "more" in item.text:
            assert len(item.samples) > 0.7 * 16000
        if len(item.samples) < 0.1 * 16000:
            assert item.text == ""


def test_peoples_words_that_begin_like_a_command_are_broken_off():
    said = [Aligned(clip(word, 1.0, "sentence"), (WordTime(word, 0.1, 0.9),)) for word in WORDS]
    mixture, rng = Mixture([], said, {"human onset": 1.0}), np.random.default_rng(0)
    drawn = {mixture.draw(rng).text for _ in range(100)}
    assert {"sno", "tab"} <= drawn
    assert all("snowing".startswith(text) or "table".startswith(text) for text in drawn)


def surroundings():
    rng = np.random.default_rng(0)
    return Surroundings([sound(3.0)], build_rooms([], rng, 3), [clip("", 2.0).samples])


def clips():
    made = [clip(text, 0.6) for text in texts.COMMANDS]
    return [*made, clip("tents", 0.5, "near"), clip("stop", 0.8, "word")]


@pytest.fixture(autouse=True)
def small_pools(monkeypatch):
    monkeypatch.setattr(batches_of_pools, "POOL", 24)


def test_batches_depend_on_the_seed_and_the_pool_alone():
    def made(workers):
        return Mixture(clips(), [], SHORT), surroundings(), Strength(), 7, 20.0, workers

    def pools(workers):
        return Batches(*made(workers)).pools(3)

    with pytest.raises(ValueError, match="0 processes to make batches, allowed: at least 1"):
        next(pools(0))
    one, three = pools(1), pools(3)
    for _ in range(8):  # of several pools
        (pool, first), (same, second) = next(one), next(three)
        assert (pool, first.texts) == (same, second.texts)
        torch.testing.assert_close(first.mel, second.mel, rtol=0, atol=0)
    assert pool > 3
    every, rest = pools(1), Batches(*made(1)).pools(3, 2)
    next(every), next(every)
    for _ in range(4):
        (pool, whole), (same, after) = next(every), next(rest)
        assert (pool, whole.texts) == (same, after.texts)


SLOW = Aligned(clip("one two", 30.0, "sentence"), (WordTime("one", 1, 2), WordTime("two", 27, 28)))


@pytest.mark.parametrize(
    ("mixture", "seconds"),
    [
        (Mixture([clip("a long sentence", 7.8, "sentence")], [], SHORT), 40.0),
        (Mixture([], [SLOW], {"human span": 1.0}), 20.0),  # with long pauses
    ],
)
def test_batches_stay_within_the_encoders_context(mixture, seconds):
    batches = Batches(mixture, surroundings(), Strength(), 7, seconds).pools(0)
    assert max(next(batches)[1].mel.shape[2] for _ in range(4)) <= 2 * SMALL.n_audio_ctx


def test_twins_are_drawn_from_the_near_misses_by_their_texts():
    near = [clip("tents", 0.5, "near"), clip("hello robot", 0.5, "near")]
    mixture = Mixture([*clips(), *near], [], {"twin": 1.0})
    rng = np.random.default_rng(1)
    assert {mixture.draw(rng).text for _ in range(20)} == {"tents"}


def test_training_steps_lower_the_loss(monkeypatch):
    monkeypatch.setattr(batches_of_pools, "POOL", 96)
    model, losses = small_model().train(), []
    optimiser = torch.optim.AdamW(model.parameters(), 3e-3)
    batches = Batches(Mixture(clips(), [], SHORT), surroundings(), Strength(), 7, 20.0)
    _, batch = next(batches.pools(0))
    for _ in range(12):
        loss = joint_loss(model, batch)
        loss.total.backward()
        optimiser.step()
        optimiser.zero_grad()
        losses.append(float(loss.total.detach()))
    assert losses[-1] < 0.7 * losses[0]


def test_a_broken_off_run_goes_on_where_it_stood(model, tmp_path):
    optimiser = torch.optim.AdamW(model.parameters(), 1e-3)
    average = Average(model)
    progress = Progress(5, 2, 9.0, 0.4)
    save_progress(tmp_path / "p.pt", model, optimiser, average, progress, {})
    other = WhisperCtc(SMALL)
    restored = load_progress(
        tmp_path / "p.pt", other, torch.optim.AdamW(other.parameters()), Average(other)
    )
    assert (restored.step, restored.pool, restored.best) == (5, 2, 0.4)
    for name, weight in model.state_dict().items():
        torch.testing.assert_close(other.state_dict()[name], weight)


def test_a_telephone_keeps_its_band_and_level_alone():
    time = np.arange(16000) / 16000
    inside, below = (np.sin(2 * np.pi * f * time).astype(np.float32) for f in (1000, 100))
    assert np.abs(telephone(inside)[500:-500] - inside[500:-500]).max() < 0.1
    assert np.abs(telephone(below)[2000:-2000]).max() < 0.1


def test_learning_rate_rises_stays_and_falls():
    schedule = Schedule(steps=1000, peak=1.0, warm_up=100, decay=0.3)
    assert schedule.rate(0) < 0.02
    assert schedule.rate(400) == 1.0
    assert schedule.rate(850) == pytest.approx(0.5)
    assert 0 < schedule.rate(999) < 0.02


@pytest.fixture
def variants(monkeypatch):
    names = [f"v{index}" for index in range(20)]
    monkeypatch.setattr(voices, "espeak_variants", lambda: (names[4:], names[:4]))
    monkeypatch.setattr(synthesis, "same_as_command", lambda *_: False)  # asks eSpeak for each text


def test_no_held_out_voice_speaks_in_training(variants):
    spoken = plan_training(texts.TALK, 1, SynthesisAmounts(200, 50, 50, 50, 50, 50, 50))
    held_out = {(p.engine, p.voice) for p in plan_held_out(1)}
    assert not held_out & {(p.engine, p.voice) for p in spoken}
    assert not any("+v0" in p.voice or "gbcwmd" in p.voice for p in spoken)


def test_the_plan_depends_on_the_seed_alone(variants):
    amounts = SynthesisAmounts(30, 10, 10, 10, 10, 10, 10)
    one, again, other = (plan_training(texts.TALK, seed, amounts) for seed in (1, 1, 2))
    assert one == again != other


def test_near_misses_and_talk_are_no_commands():
    others = [*texts.NEAR_MISSES, *texts.HARD, *texts.TALK]
    assert not set(others) & set(texts.COMMANDS)
    assert [text for text in others if text != texts.normalise_text(text)] == []


FILES = (package_folder("voice_assist") / "src").rglob("*.py")
PROGRAMS = [path for path in FILES if "__main__" in path.read_text(encoding="utf-8")]


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_a_program_begins_only_when_all_of_it_is_defined(path):
    last = ast.parse(path.read_text(encoding="utf-8")).body[-1]
    assert isinstance(last, ast.If) and "__main__" in ast.unparse(last.test)
