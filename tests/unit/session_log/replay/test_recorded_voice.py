# SPDX-License-Identifier: BSD-3-Clause
"""Each run of the voice node has the settings that it ran with, and the notes that it made."""

import json

import pytest
import yaml

from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.recover import recover
from session_log.mcap_file.writer import SessionWriter
from session_log.replay.command import REPLAY_CONFIG
from session_log.replay.config import ReplayConfig
from session_log.replay.recorded_voice import read_voice
from support.story import Story, numbered, recording_of
from tests.unit.session_log.support.voice_recording import BLOCK, note, say_sound
from typed_config import load_file


@pytest.fixture
def models_of(tmp_path):
    """The model of each run of a session: blocks of sound by first sample, and named models."""

    def read(*parts):
        story = Story()
        with SessionWriter(tmp_path / "session.mcap") as writer:
            for k, part in enumerate(parts):
                if isinstance(part, str):
                    settings = yaml.safe_dump({"model": part})
                    writer.add_metadata("parameters", {"voice_assist": settings})
                    writer.add_metadata("session/voice_assist", {"model": part})
                else:
                    say_sound(story, 1.0 + k, part)
                    writer.add(story.messages[-1])
                writer.commit()
        reader = SessionReader(tmp_path / "session.mcap")
        recover(reader, tmp_path / "session_recovered.mcap")
        found = found_in(reader)
        assert found_in(SessionReader(tmp_path / "session_recovered.mcap")) == found
        return found

    return read


def found_in(reader):
    runs = read_voice(reader, load_file(ReplayConfig, REPLAY_CONFIG)).runs
    found = [run.settings.get("model") for run in runs]
    assert [run.facts.get("model") for run in runs] == found
    return found


def test_what_the_next_run_records_before_its_sound_is_not_of_the_run_before(models_of):
    assert models_of("a", 0, BLOCK, "b", 0, BLOCK) == ["a", "b"]


def test_what_is_recorded_during_a_run_is_its_own(models_of):
    assert models_of("a", 0, "b", BLOCK, "c", 0, "d", BLOCK) == ["b", "d"]


def test_the_last_run_has_what_was_recorded_last(models_of):
    assert models_of("a", 0, "b", 0, BLOCK, "c") == ["a", "c"]


def test_a_run_that_ended_before_anything_was_recorded_has_no_settings(models_of):
    assert models_of(0, "b", 0) == [None, "b"]


@pytest.mark.parametrize(
    ("firsts", "notes", "counts"),
    [
        ((0, 10_000, 0), {1: [9_000, 10_000]}, (2, 0)),
        ((0, 10_000, 0), {1: [0, 0]}, (0, 2)),
        ((0, 10_000, 1_600), {1: [10_400, 9_800, 0, 500, 1_600]}, (2, 3)),
        ((0, 10_000, 0), {1: [10_512, None, 0, None]}, (2, 2)),
        ((10_000, 0), {0: [9_000, 10_512, 0, 512]}, (2, 2)),
        ((5_000, 0), {-1: [4_000], 1: [512, 1_024]}, (1, 2)),
        ((0, 10_000), {1: [9_000, 0, 512]}, (1,)),  # of a run without any sound
    ],
)
def test_notes_before_the_first_sound_of_a_run_are_its_own(tmp_path, firsts, notes, counts):
    story = Story()
    for k in range(-1, len(firsts)):
        if k >= 0:
            say_sound(story, 1.0 + k, firsts[k])
        for sample in notes.get(k, ()):
            text = "no sample" if sample is None else json.dumps({"sample": sample})
            note(story, 1.5 + k, text)
    reader = recording_of(tmp_path / "session.mcap", numbered(story.messages))
    runs = read_voice(reader, load_file(ReplayConfig, REPLAY_CONFIG)).runs
    assert tuple(len(run.notes) for run in runs) == counts
