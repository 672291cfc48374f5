# SPDX-License-Identifier: BSD-3-Clause
"""The pipeline as shipped, model and detector included, on speech of espeak-ng."""

import itertools
import subprocess
import time

import pytest

from voice_assist.assembly import make_pipeline, make_recognizer
from voice_assist.audio.sound_file import read_sound
from voice_assist.config import load_voice_config
from voice_assist.evaluation.evaluator import Evaluator, LabelledClip
from voice_assist.types import Mode

COMMANDS = ("hey robot", "tense", "release", "pull more", "pull less", "stop", "terminate")
VOICES = ("en-us", "en-gb")
TALK = (
    "he told me that the next patient is here",
    "the lights were far too dim in the other room",
    "do not pull more",
)


STALL = 1.2  # [s]


class Stalling:
    """A recogniser on a machine that stalls in one decoder pass; also the clock of its work.

    It counts the work alone: what other programs take of the machine is no delay of the pipeline.
    """

    def __init__(self, recognizer):
        self._recognizer, self._stalled = recognizer, 0.0
        self.start()

    def start(self, stalls_at=None):
        self.passes, self._stalls_at = 0, stalls_at

    def now(self):
        return time.process_time() + self._stalled

    def transcribe(self, *sound):
        self.passes += 1
        self._stalled += STALL * (self.passes == self._stalls_at)
        return self._recognizer.transcribe(*sound)

    def __getattr__(self, name):
        return getattr(self._recognizer, name)


@pytest.fixture(scope="module")
def recognizer():
    return Stalling(make_recognizer(load_voice_config()))


@pytest.fixture(scope="module")
def evaluator(recognizer):
    config, timer = load_voice_config(), recognizer.now
    make = lambda clock: make_pipeline(config, clock, recognizer)  # noqa: E731
    return Evaluator(make, Mode.ACTIVE.value, timer=timer)


def spoken(folder, text, voice):
    path = folder / "clip.wav"
    words = ["espeak-ng", "-v", voice, "-s", "150", "-w", str(path), text]
    subprocess.run(words, check=True)
    assert len(read_sound(path)) > 3000
    return LabelledClip(2, path, text, "")


@pytest.mark.parametrize(("command", "voice"), zip(COMMANDS, itertools.cycle(VOICES)))
def test_a_spoken_command_is_taken_for_what_it_is(evaluator, tmp_path, command, voice):
    outcome = evaluator(spoken(tmp_path, command, voice))
    assert [t.command for t in outcome.taken] == [command], (outcome.heard, outcome.why)


def test_a_stall_in_any_pass_delays_a_command_and_refuses_none(evaluator, recognizer, tmp_path):
    clip = spoken(tmp_path, "pull less", "en-us")
    recognizer.start()
    evaluator(clip)
    passes = recognizer.passes
    assert passes > 4
    for stalls_at in range(1, passes + 1):
        recognizer.start(stalls_at)
        outcome = evaluator(clip)
        assert [t.command for t in outcome.taken] == ["pull less"], (stalls_at, outcome.why)


@pytest.mark.parametrize("text", TALK)
def test_talk_does_not_move_the_robot(evaluator, tmp_path, text):
    outcome = evaluator(spoken(tmp_path, text, "en-gb+m3"))
    motions = {"tense", "release", "pull more", "pull less"}
    assert not motions & {t.command for t in outcome.taken}, outcome.heard
