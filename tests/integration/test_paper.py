# SPDX-License-Identifier: BSD-3-Clause
"""The shortest form of `make paper`: one voice says every command once to the whole system."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap_ros1.decoder import DecoderFactory

ROOT = Path(__file__).resolve().parents[2]
VOICE = "espeak-german"  # whose order of phrases grasps once
LIMIT = 280.0  # [s] on a loaded machine, less than pytest gives: what hangs is ended
COMMANDS = {"hey robot", "tense", "release", "pull more", "pull less", "stop", "terminate"}


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    out = tmp_path_factory.mktemp("paper")
    words = ["--session", "--voices", VOICE, "--repetitions", "1", "--out", str(out)]
    done = subprocess.run(
        [sys.executable, "-m", "paper", *words],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=LIMIT,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return out / VOICE


@pytest.fixture(scope="module")
def outcomes(session):
    return json.loads((session / "outcomes.json").read_text())


def test_every_command_was_said_and_most_were_taken(outcomes):
    said = [o for o in outcomes if o["command"]]
    assert {o["command"] for o in said} == COMMANDS
    right = [o for o in said if o["taken"] == [o["command"]]]
    assert len(right) >= 0.6 * len(said), outcomes


def test_nothing_came_of_the_talk(outcomes):
    talk = [o for o in outcomes if not o["command"]]
    assert talk and all(o["taken"] == [] for o in talk)


def test_what_was_taken_moved_the_robot_after_the_decision(outcomes):
    motions = [o for o in outcomes if o["command"] in ("tense", "pull more", "pull less")]
    moved = [o for o in motions if o["taken"] == [o["command"]] and o["is_whole"]]
    assert moved, outcomes
    assert all(o["refusal"] or o["acted"] > o["decided"] for o in moved)


def test_the_sound_was_found_in_what_the_voice_node_heard(outcomes):
    assert sum(o["is_whole"] for o in outcomes) >= 0.6 * len(outcomes)


def test_the_recording_says_what_was_meant(session, outcomes):
    with (session / "session.mcap").open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        intended = [
            message.data
            for _, _, _, message in reader.iter_decoded_messages(topics=["/voice_assist/intended"])
        ]
    assert intended == [o["command"] for o in outcomes]
