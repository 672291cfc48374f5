# SPDX-License-Identifier: BSD-3-Clause
"""The gate with every real part: one voice moves the robot, another does not, and both stop it."""

import numpy as np
import pytest

from voice_assist.assembly import make_pipeline, make_recognizer
from voice_assist.audio.source import FRAME, Framer
from voice_assist.config import load_voice_config
from voice_assist.speaker.cohort import read_cohort
from voice_assist.speaker.network import VoiceNetwork
from voice_assist.speaker.voiceprint import make_voiceprint
from voice_assist.training.data.voices import Prompt, speak
from voice_assist.types import RATE, Call, Halt, Mode, NoMatch, UtteranceDecision

SURGEON, VISITOR = "en-us+m3", "en-us+f4"
TAKES = ("tense", "release", "pull more", "pull less", "hey robot", "terminate", "stop")


def said(text, voice, rate=1.0):
    (sound,) = speak([Prompt(text, "espeak", voice, rate, 0.5)])
    return sound.astype(np.float32) / 32768.0


@pytest.fixture(scope="module")
def pipeline():
    config = load_voice_config(speaker__gate="on")
    cohort, digest = read_cohort()
    takes = [said(text, SURGEON, rate) for text in TAKES for rate in (0.9, 1.0, 1.1)]
    known = make_voiceprint(takes, VoiceNetwork(), cohort, digest, config.speaker)
    recognizer = make_recognizer(config)
    return make_pipeline(config, lambda: 0.0, recognizer, voiceprint=known.to_bytes())


def hear(pipeline, text, voice):
    quiet = 1e-4 * np.random.default_rng(1).standard_normal(RATE)
    sound = np.concatenate([quiet, said(text, voice, 0.95), quiet, quiet]).astype(np.float32)
    pipeline.reset()
    pipeline.set_mode(Mode.ACTIVE, "test")
    frames = Framer().push(sound[: len(sound) // FRAME * FRAME], 0.0)
    return [e for frame in frames for e in pipeline(frame) if isinstance(e, UtteranceDecision)]


@pytest.mark.parametrize("phrase", ["tense", "pull more"])
def test_the_enrolled_voice_moves_and_another_does_not(pipeline, phrase):
    own = hear(pipeline, phrase, SURGEON)
    assert [a for d in own for a in d.actions] == [Call(phrase)], own
    other = hear(pipeline, phrase, VISITOR)
    assert [a for d in other for a in d.actions] == []
    assert [d.outcome.rejection.words[:14] for d in other if isinstance(d.outcome, NoMatch)] == [
        "not this voice"
    ]


@pytest.mark.parametrize("voice", [SURGEON, VISITOR])
def test_both_voices_stop(pipeline, voice):
    assert any(Halt() in d.actions for d in hear(pipeline, "stop", voice))


@pytest.mark.parametrize("text", ["do not pull more", "he will pull more later"])
def test_the_enrolled_voice_moves_nothing_by_what_is_no_command(pipeline, text):
    assert [a for d in hear(pipeline, text, SURGEON) for a in d.actions] == []
