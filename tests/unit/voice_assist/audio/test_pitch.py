# SPDX-License-Identifier: BSD-3-Clause
import itertools

import numpy as np
import pytest

from support.theatre_sound import speak
from tests.unit.voice_assist.support import fake_speech
from tests.unit.voice_assist.support.fake_pipeline import commands, hear, make, refusals, run
from voice_assist.audio.pitch import pitch_variation
from voice_assist.config import load_voice_config
from voice_assist.types import RATE

LEAST = load_voice_config().recognizer.motion_pitch_variation


def notes(pitches, harmonics, length=0.16, gap=0.06):
    """A burst of notes with silence between them."""
    time = np.arange(round(length * RATE)) / RATE
    rise = np.minimum(1.0, np.minimum(time / 0.01, (length - time) / 0.03))
    silence = np.zeros(round(gap * RATE))
    parts = [silence]
    for pitch in pitches:
        waves = [np.sin(2 * np.pi * k * pitch * time) / k for k in range(1, harmonics + 1)]
        parts += [rise * np.sum(waves, axis=0), silence]
    return 0.3 * np.concatenate(parts)


def with_noise(sound, snr):
    """At a level below that of the loud part [dB]."""
    loud = np.sqrt(np.mean(sound[sound != 0.0] ** 2))
    noise = np.random.default_rng(1).standard_normal(len(sound))
    return (sound + loud * 10 ** (-snr / 20) * noise).astype(np.float32)


@pytest.mark.parametrize(
    ("base", "harmonics", "snr"),
    [
        *itertools.product((150.0, 262.0, 440.0, 990.0), (1, 4, 6), (60, 30)),
        *itertools.product((262.0, 440.0, 990.0), (1, 4, 6), (20, 10)),  # deeper ones not surely
    ],
)
def test_bursts_of_alarms_are_tones(base, harmonics, snr):
    for steps in ((1.0,), (1.0, 1.26), (1.0, 1.26, 1.5), (1.0, 1.0, 1.0, 2.0, 2.0)):
        sound = with_noise(notes([base * step for step in steps], harmonics), snr)
        assert pitch_variation(sound) < LEAST


@pytest.mark.parametrize("command", ["tense", "release", "pull more", "pull less"])
@pytest.mark.parametrize("voice", ["en-us", "en-gb+m3", "en-us+f3"])
def test_voices_are_none(voice, command):
    sound = speak(command, voice, 150)
    assert pitch_variation(sound) > 5.0 * LEAST
    assert pitch_variation(with_noise(sound.astype(np.float64), 0)) > 5.0 * LEAST


@pytest.mark.parametrize("sound", [np.zeros(0), np.zeros(900), np.zeros(RATE)])
def test_too_little_sound_is_no_tone(sound):
    assert pitch_variation(sound.astype(np.float32)) == float("inf")


def test_an_octave_up_between_two_steady_notes_is_still_a_tone():
    assert pitch_variation(notes((300.0, 600.0), 4).astype(np.float32)) < 0.2


@pytest.fixture
def steady(monkeypatch):
    """The language of tones as it would sound from a machine that keeps its pitch."""
    monkeypatch.setattr(fake_speech, "_GLIDE", 0.0)


@pytest.mark.usefixtures("steady")
@pytest.mark.parametrize("command", ["tense", "release", "pull more", "pull less"])
def test_a_tone_moves_nothing_and_the_reason_says_so(command):
    events = hear(command)
    assert commands(events) == []
    (refusal,) = refusals(events)
    assert refusal.nearest_command == command
    assert refusal.rejection.words.startswith("a tone, no voice: its pitch moves by ")
    assert commands(hear(command, recognizer__motion_pitch_variation=0.0)) == [command]


@pytest.mark.usefixtures("steady")
@pytest.mark.parametrize("command", ["stop", "hey robot", "terminate"])
def test_what_moves_nothing_may_be_a_tone(command):
    assert commands(hear(command)) == [command]


def test_a_command_after_an_alarm_is_heard():
    pipeline, clock = make()
    alarm = notes((3700.0, 3750.0, 3700.0), 1)  # no word of the language of tones
    sound = np.concatenate([alarm, fake_speech.say("tense", before=1.5)]).astype(np.float32)
    assert commands(run(pipeline, clock, fake_speech.frames(sound))) == ["tense"]
