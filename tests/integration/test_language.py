# SPDX-License-Identifier: BSD-3-Clause
"""The system with language:=de: German words move the robot, and a missing model is named."""

import numpy as np
import pytest
import soundfile

from support.waiting import PATIENCE, wait_until
from tests.support.ros_host import ASK
from voice_assist.recognizer.checkpoint import FETCH, multilingual_path
from voice_assist.training.data.voices import Prompt, speak
from voice_assist.types import RATE

PAUSE, ROUNDS = 4.0, 8  # [s] before each word; times that all is said, until everything runs
AGAIN = 1.5  # [s] before a motion is said again


@pytest.mark.skipif(not multilingual_path().is_file(), reason=FETCH)
def test_german_words_move_the_robot_and_alarms_are_german(host, tmp_path):
    words = {
        "hallo roboter": PAUSE,
        "gewebe spannen": PAUSE,
        "Gewebe spannen": AGAIN,
        "halt": PAUSE,
    }
    said = speak([Prompt(word, "espeak", "de+f4", 1.0, 0.5) for word in words])
    quiet = [np.zeros(round(pause * RATE), np.int16) for pause in words.values()]
    sound = np.concatenate([part for pair in zip(quiet, said, strict=True) for part in pair])
    soundfile.write(tmp_path / "german.wav", np.tile(sound, ROUNDS), RATE)
    host.launch(
        "system",
        language="de",
        source="wav",
        wav=tmp_path / "german.wav",
        alarm_sound="false",
        sessions=tmp_path,
    )
    wait_until(lambda: host.is_found("/rst_control/command"), "a controller", every=ASK)
    for line in ("hey robot: ", "tense: ", "stop: ", "„hallo roboter“"):
        wait_until(lambda line=line: line in host.said(), line, every=ASK)


def test_without_its_model_the_voice_node_ends_and_names_what_fetches_it(host, tmp_path):
    nothing = {"XDG_DATA_HOME": str(tmp_path)}
    launch = host.launch("voice", nothing, language="de", source="topic", prefix="")
    launch.wait(PATIENCE)
    assert "`make languages` fetches Whisper base" in host.said()
