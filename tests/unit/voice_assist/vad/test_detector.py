# SPDX-License-Identifier: BSD-3-Clause
"""What is said right after sound that deafens is heard: with the networks as shipped."""

import numpy as np
import pytest

from support.theatre_sound import speak
from voice_assist.assembly import make_pipeline
from voice_assist.audio.source import FRAME, Framer
from voice_assist.config import load_voice_config
from voice_assist.evaluation.evaluator import StreamClock
from voice_assist.types import RATE, Match, Mode, UtteranceDecision
from voice_assist.vad.detector import LONG, REST, OverloadRecovery

ROOM = 1e-3
STEP = FRAME / RATE  # [s]


def noise(seconds, amplitude=ROOM, seed=5):
    return amplitude * np.random.default_rng(seed).standard_normal(round(seconds * RATE))


def mains(seconds):
    time = np.arange(round(seconds * RATE)) / RATE
    return 10.0 * np.sin(2 * np.pi * 50.0 * time) + noise(seconds, 0.01)


def frames(*sounds):
    return list(Framer().push(np.clip(np.concatenate(sounds), -1.0, 1.0), 0.0))


def ends_of_overload(*sounds):
    """When deafening sound was found to be over [s]."""
    watch = OverloadRecovery()
    return [f.end for f in frames(*sounds) if watch.is_over(f)]


def test_the_end_of_deafening_sound_is_found_once():
    (at,) = ends_of_overload(noise(1.0), mains(2.0), noise(3.0))
    assert at == pytest.approx(3.0 + REST, abs=2 * STEP)
    assert len(ends_of_overload(mains(1.0), noise(1.0), mains(1.0), noise(1.0))) == 2


@pytest.mark.parametrize(
    "sounds",
    [
        [noise(3.0)],
        [mains(LONG - 2 * STEP), noise(1.0)],  # a door that bangs
        [noise(3.0, 0.2), noise(1.0)],  # loud, yet nothing that overloads
        [np.tile(speak("stop they will bring the table", "en-us", 150), 3), noise(1.0)],
    ],
)
def test_other_sound_leaves_the_detector_alone(sounds):
    assert ends_of_overload(*sounds) == []


def test_a_pause_as_short_as_between_two_consonants_is_no_end():
    assert ends_of_overload(mains(1.0), noise(REST - 2 * STEP), mains(1.0)) == []


@pytest.fixture(scope="module")
def pipeline():
    return make_pipeline(load_voice_config(), StreamClock())


@pytest.mark.parametrize("pause", [0.8, 1.5])
@pytest.mark.parametrize(
    "before",
    [
        pytest.param(mains(6.0), id="the mains at full scale"),
        pytest.param(np.random.default_rng(1).uniform(-1.0, 1.0, 6 * RATE), id="random bytes"),
        pytest.param(noise(6.0, 0.18), id="noise at -15 dB, as of suction beside the microphone"),
        pytest.param(noise(6.0), id="a quiet room"),
    ],
)
def test_a_stop_soon_after_it_is_heard(pipeline, before, pause):
    pipeline.reset()
    pipeline.set_mode(Mode.ACTIVE, "test")
    taken = []
    for frame in frames(before, noise(pause), speak("stop", "en-us", 150), noise(1.5)):
        decided = [e.outcome for e in pipeline(frame) if isinstance(e, UtteranceDecision)]
        taken += [one.command for one in decided if isinstance(one, Match)]
    assert taken == ["stop"]
