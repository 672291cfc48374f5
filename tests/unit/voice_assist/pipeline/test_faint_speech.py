# SPDX-License-Identifier: BSD-3-Clause
"""Noise so loud that the detector is never sure of speech: a stop counts, a motion does not."""

import pytest

from tests.unit.voice_assist.support.fake_pipeline import commands, make, refusals, run
from tests.unit.voice_assist.support.fake_speech import frames, make_detector, say
from voice_assist.config import load_voice_config
from voice_assist.types import Mode

VAD = load_voice_config().audio.vad
LEAST = load_voice_config().recognizer.motion_speech
MOTIONS = ("tense", "release", "pull more", "pull less")


class Unsure:
    """A detector that finds speech where there is some, and is never surer than `most`."""

    def __init__(self, most):
        self._detector, self._most = make_detector(), most

    def reset(self):
        self._detector.reset()

    def __call__(self, samples):
        return self._most * self._detector(samples)


def hear(text, most, mode=Mode.ACTIVE):
    return run(*make(mode, detector=Unsure(most)), frames(say(text)))


@pytest.mark.parametrize("command", MOTIONS)
def test_a_motion_in_it_is_refused_with_the_probability_and_what_is_allowed(command):
    assert VAD.start < LEAST  # there is such speech with the settings as they are
    events = hear(command, LEAST - 0.05)
    assert commands(events) == []
    (refusal,) = refusals(events)
    assert refusal.nearest_command == command
    gave = f"gave {LEAST - 0.05:.2f} at most, allowed: at least {LEAST:.2f}"
    assert refusal.rejection.words == f"too faint to be surely speech: the speech detector {gave}"
    # a little clearer it is taken
    assert commands(hear(command, LEAST + 0.05)) == [command]


@pytest.mark.parametrize("mode", [Mode.ACTIVE, Mode.STANDBY])
def test_a_stop_in_it_counts_in_any_mode_and_what_is_fainter_still_is_not_decoded(mode):
    assert commands(hear("stop", VAD.start + 0.03, mode)) == ["stop"]
    assert hear("stop", VAD.start - 0.03, mode) == []


@pytest.mark.parametrize("command", ["hey robot", "terminate"])
def test_what_moves_nothing_counts_too(command):
    assert commands(hear(command, LEAST - 0.05)) == [command]
