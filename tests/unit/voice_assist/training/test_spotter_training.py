# SPDX-License-Identifier: BSD-3-Clause
from dataclasses import replace

import numpy as np
import pytest

from voice_assist.config import load_voice_config
from voice_assist.errors import VoiceError
from voice_assist.spotter.features import STEP, Embedder, seconds
from voice_assist.training.data.noise import Surroundings, build_rooms
from voice_assist.training.data.synthesis import TrainingClip
from voice_assist.training.spotter import rule
from voice_assist.training.spotter.dataset import IGNORED, NEAR, NEGATIVE, label
from voice_assist.training.spotter.embed import LongEmbedder
from voice_assist.training.spotter.rule import Count, choose, fired, fired_at
from voice_assist.training.spotter.streams import (
    WORD,
    LabelledStream,
    Style,
    noise_streams,
    streams,
)
from voice_assist.training.spotter.trials import NEVER, SpotterTrial, TrialEvidence
from voice_assist.types import RATE

RULE = {"alone": 8.0, "middle": 4.0, "agree": 1.0, "near": 3.0, "sure": 0.9}
CONFIG = replace(load_voice_config().spotter, **RULE)


@pytest.mark.parametrize("length", [0, STEP - 1, STEP, 9 * STEP + 5, 30 * STEP])
def test_several_embeddings_at_once_are_those_one_by_one(length):
    sound = 0.1 * np.random.default_rng(0).standard_normal(length).astype(np.float32)
    one_by_one = list(Embedder()(sound))
    at_once = LongEmbedder()(sound)
    assert at_once.shape == (length // STEP, 96)
    for one, other in zip(one_by_one, at_once, strict=True):
        np.testing.assert_array_equal(one, other)


def surroundings(*talkers):
    return Surroundings((), build_rooms((), np.random.default_rng(0), count=3), talkers)


def test_a_word_is_where_its_stream_says():
    tone = (8000 * np.sin(np.arange(4000) * 0.3)).astype(np.int16)
    padded = np.concatenate([np.zeros(3200, np.int16), tone, np.zeros(1600, np.int16)])
    clips = [TrainingClip(padded, text, "word", "x") for text in ("up", "stop", "go", "stop")]
    style = Style(speed=(0.8, 0.8), room=0.0, noise=0.0)
    (stream,) = streams(clips, surroundings(), style, np.random.default_rng(1))
    assert len(stream.words) == 2
    for begin, end in stream.words:
        assert end - begin == pytest.approx(4000 / 0.8 / RATE, abs=0.02)
        inside = stream.sound[int(begin * RATE) : int(end * RATE)]
        before = stream.sound[int((begin - 0.1) * RATE) : int((begin - 0.02) * RATE)]
        assert np.std(inside) > 20 * np.std(before)


def test_what_is_said_like_the_word_does_not_hold_it():
    assert not [text for text in NEAR if WORD in text.split()]


def test_a_voice_under_the_words_is_there_without_pause_and_as_loud_as_asked():
    tone = (8000 * np.sin(np.arange(8000) * 0.3)).astype(np.int16)
    talker = (5000 * np.sin(np.arange(40000) * 0.05)).astype(np.int16)
    clips = [TrainingClip(tone, "stop", "word", "x")] * 6
    alone = Style(speed=(1.0, 1.0), room=0.0, noise=0.0, gap=(0.3, 0.5))
    over = replace(alone, talker=1.0, over=(0.0, 0.0))
    (quiet,), (busy,) = (
        streams(clips, surroundings(talker), style, np.random.default_rng(1))
        for style in (alone, over)
    )
    gap = slice(int((busy.words[0][1] + 0.05) * RATE), int((busy.words[1][0] - 0.05) * RATE))
    word = slice(*(int(t * RATE) for t in busy.words[0]))
    assert np.std(quiet.sound[gap]) < 0.1 * np.std(quiet.sound[word])
    assert np.std(busy.sound[gap]) > 0.4 * np.std(busy.sound[word])
    assert len(busy.words) == len(clips)


def test_noise_has_no_word_and_stays_in_range():
    made = list(noise_streams(surroundings(), 6, np.random.default_rng(2)))
    assert len(made) == 6
    assert all(stream.words == () and np.abs(stream.sound).max() <= 1.0 for stream in made)


def test_looks_at_the_end_of_a_word_are_its_own_and_those_around_it_are_nobodys():
    labels = label(LabelledStream(np.zeros(0, np.float32), ((1.0, 1.5),)), 60, 7)
    times = np.array([seconds(step) for step in range(60)])
    spans = {(-1, 1.0): NEGATIVE, (1.05, 1.45): IGNORED, (1.5, 1.85): 7, (2.45, 99): NEGATIVE}
    for (after, before), wanted in spans.items():
        assert set(labels[(times > after) & (times < before)]) == {wanted}


def trial(best, heard=(), weight=1.0, seconds=3600.0):
    return SpotterTrial("x", seconds, 1.0, weight, tuple(heard), ((0.8, -5.0), (1.2, best)))


def test_the_first_rule_to_hold_gives_the_time():
    assert fired_at(trial(7.9), CONFIG) is None
    assert fired_at(trial(8.0), CONFIG) == 1.2
    sure = TrialEvidence(1.1, -9.0, 0.95, True, True, NEVER)
    assert fired_at(trial(8.0, [sure]), CONFIG) == 1.1
    near = TrialEvidence(1.4, 5.0, -1.0, False, False, -2.0)
    far = TrialEvidence(1.3, 5.0, -1.0, False, False, -4.0)
    assert fired_at(trial(7.0, [far, near]), CONFIG) == 1.4


def test_the_recogniser_alone_ignores_the_spotter_and_the_other_way_round():
    unsure = TrialEvidence(1.3, -9.0, 0.62, True, True, NEVER)
    both = [trial(9.0), trial(-9.0, [unsure])]
    recogniser = rule.recogniser_alone(CONFIG)
    spotter = rule.spotter_alone(CONFIG, 8.0)
    assert [fired_at(t, recogniser) is not None for t in both] == [False, True]
    assert [fired_at(t, spotter) is not None for t in both] == [True, False]


def test_the_chosen_thresholds_keep_the_rates_or_are_refused_and_find_what_both_half_believe():
    unsure = TrialEvidence(1.2, 2.0, 0.7, True, True, NEVER)
    said = {"people": [trial(9.0), trial(2.0, [unsure]), trial(9.5)]}
    alone_unsure = TrialEvidence(1.2, -5.0, 0.7, True, True, NEVER)
    talk = [trial(2.5), trial(-5.0, [alone_unsure]), trial(-9.0, weight=8.0)]
    chosen = choose(CONFIG, said, {"people": 1.0}, talk, alone_rate=0.05, rate=0.05)
    assert fired(said["people"], chosen).found == 3
    assert rule.false_stops(talk, chosen) == 0.0
    assert chosen.alone > 2.5
    sure = [TrialEvidence(1.2, 20.0, 1.0, True, True, NEVER)]
    with pytest.raises(VoiceError, match="false stops per hour"):
        choose(CONFIG, {"p": [trial(9.0)]}, {"p": 1.0}, [trial(20.0, sure)] * 3, 0.1, 0.1)


def test_intervals_are_exact():
    assert Count(0, 10).interval == (0.0, pytest.approx(0.3085, abs=1e-4))
    assert Count(109, 112).interval[0] == pytest.approx(0.9237, abs=1e-4)
