# SPDX-License-Identifier: BSD-3-Clause
"""The pipeline as shipped, model and detector included, on speech of espeak-ng."""

import itertools
import subprocess
import time

import pytest

from voice_assist.assembly import make_pipeline
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


@pytest.fixture(scope="module")
def evaluator():
    config = load_voice_config()
    # By the work alone: what other programs take of the machine is no delay of the pipeline.
    timer = time.process_time
    return Evaluator(lambda clock: make_pipeline(config, clock), Mode.ACTIVE.value, timer=timer)


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


@pytest.mark.parametrize("text", TALK)
def test_talk_does_not_move_the_robot(evaluator, tmp_path, text):
    outcome = evaluator(spoken(tmp_path, text, "en-gb+m3"))
    motions = {"tense", "release", "pull more", "pull less"}
    assert not motions & {t.command for t in outcome.taken}, outcome.heard
