# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest

from bench.voice.calibration import Reliability, draw, reliability
from bench.voice.material import theatre_noise
from bench.voice.material.confusable_phrases import ALL, DENIED, IN_A_SENTENCE, SOUNDS_LIKE
from bench.voice.speaker_gate import Trials, _rates
from voice_assist.config import load_voice_config
from voice_assist.intent.mapper import Mapper
from voice_assist.text.normalize import is_negated, normalize
from voice_assist.types import RATE, Match

CONFIG = load_voice_config()


# --- speaker gate


def test_the_bounds_of_the_equal_error_are_those_of_speakers_that_differ():
    known, unknown = np.full(50, 3.0), np.r_[np.full(10, -3.0), np.full(40, 3.0)]
    (figure,) = _rates("all", Trials((known, unknown), np.r_[np.full(90, -2.0), np.full(10, 4.0)]))
    assert figure.value == pytest.approx(10.0)
    assert "2 speakers, 100 own and 100 other trials" in figure.note
    assert (figure.lower, figure.upper) == (0.0, 20.0)  # one speaker or the other, drawn twice
    (alone,) = _rates("all", Trials((known,), np.full(90, -2.0)))
    assert (alone.value, alone.lower) == (0.0, 0.0) and alone.upper == pytest.approx(7.11, abs=0.01)


# --- calibration


def test_calibration_error_is_the_weighted_gap_of_the_bins():
    sure = [0.95] * 8 + [0.55] * 2
    right = [True] * 6 + [False] * 2 + [True, False]
    curve = reliability(sure, right)
    assert curve.count.tolist() == [2, 8]
    assert curve.right.tolist() == [0.5, 0.75]
    assert curve.error == pytest.approx(0.2 * 0.05 + 0.8 * 0.20)


def test_confidence_that_keeps_its_word_has_almost_no_error():
    rng = np.random.default_rng(3)
    sure = rng.uniform(size=20_000)
    honest = reliability(sure, rng.uniform(size=20_000) < sure)
    boastful = reliability(np.sqrt(sure), rng.uniform(size=20_000) < sure)
    assert honest.error < 0.02
    assert boastful.error > 0.1


def test_full_confidence_falls_into_the_last_bin():
    curve = reliability([1.0, 0.95], [True, False])
    assert curve.count.tolist() == [2]


def test_plot_is_a_picture(tmp_path):
    curve = Reliability(np.array([0.3, 0.9]), np.array([0.2, 0.95]), np.array([5, 40]))
    draw({"all": curve, "motion": curve}, tmp_path / "plots" / "r.png")
    assert (tmp_path / "plots" / "r.png").read_bytes()[:4] == b"\x89PNG"


# --- phrases


def test_no_near_miss_is_a_command_in_words():
    mapper = Mapper(CONFIG.commands)
    taken = [p for phrases in ALL.values() for p in phrases if isinstance(mapper(p), Match)]
    assert taken == []


def test_near_misses_are_many_distinct_and_normalised():
    phrases = [*SOUNDS_LIKE, *DENIED, *IN_A_SENTENCE]
    assert len(set(phrases)) == len(phrases) >= 200
    assert all(p == p.strip().lower() and p for p in phrases)


def test_every_denied_phrase_denies():
    assert [p for p in DENIED if not is_negated(normalize(p))] == []


# --- noises


@pytest.mark.parametrize(
    "kind", sorted(set(theatre_noise.KINDS) - {"replies", "speaking", "recorded", "quoting"})
)
def test_noise_is_the_same_from_the_same_seed_and_stays_in_range(kind):
    sound = theatre_noise.make(kind, 3.0, 5)
    assert sound.shape == (3 * RATE,)
    assert sound.dtype == np.float32
    assert np.abs(sound).max() <= 1.0
    assert np.array_equal(sound, theatre_noise.make(kind, 3.0, 5))
    assert not np.array_equal(sound, theatre_noise.make(kind, 3.0, 6))
    assert np.std(sound) > 1e-4


def test_silence_is_quieter_than_any_other_noise():
    made = set(theatre_noise.KINDS) - {"replies", "speaking", "recorded", "quoting"}
    loud = {k: np.std(theatre_noise.make(k, 3.0, 1)) for k in made}
    assert min(loud, key=loud.get) == "silence"
