# SPDX-License-Identifier: BSD-3-Clause
"""False commands in people's talk while the robot moves."""

from types import SimpleNamespace

import numpy as np
import pytest

from bench.voice.hearing import pieces
from bench.voice.hearing.pieces import SceneRecord
from bench.voice.hearing.replay_stream import SceneDecision, SceneResult
from bench.voice.material import mixing
from bench.voice.material.synthesis import SpokenClip
from bench.voice.no_commands import armed, moving

CLIPS = [SpokenClip("human", path, "", path) for path in ("a.wav", "b.wav")]


def heard(trial):
    """What is made of a trial: in the first clip a stop is taken, in the second nothing is."""
    label, scene = trial.scene()
    assert scene.is_moving
    stop = SceneDecision(1.0, "stop", True, 0.9, "recognizer", "stop", "")
    said = (stop,) if trial.clip is CLIPS[0] else ()
    return SceneRecord({**label, "seconds": 1800.0}, SceneResult(said, 1800.0, 1.0, 1800.0))


@pytest.fixture
def material(monkeypatch, tmp_path):
    """Two clips of talk, and their pieces; the model of `make languages` may be put there."""
    monkeypatch.setattr(moving, "clips", lambda: CLIPS)
    monkeypatch.setattr(armed, "clips", lambda: CLIPS)
    monkeypatch.setattr(armed, "recorded", lambda *_: [])
    monkeypatch.setattr(armed, "length", lambda _: 1.0)
    for module in (mixing, moving):
        monkeypatch.setattr(module, "read_sound", lambda _: np.ones(16_000, np.float32))
    made = {}

    def measured(part, plans):
        made[part] = [heard(trial) for chunk in plans[""] for trial in chunk.trials]
        return {"": made[part]}

    monkeypatch.setattr(pieces, "measured", measured)
    monkeypatch.setattr(moving.resumable, "write_details", lambda *_: None)
    monkeypatch.setattr(moving, "multilingual_path", lambda: tmp_path / "model.pt")
    return tmp_path / "model.pt"


@pytest.mark.parametrize(("text", "count"), [("We'll stop there.", 1), ("He stopped.", 0)])
def test_a_stop_counts_and_another_recogniser_says_where_the_word_was_said(
    material, monkeypatch, text, count
):
    material.touch()
    judge = SimpleNamespace(transcribe=lambda *_, **__: {"text": text})
    monkeypatch.setattr(moving, "load_multilingual", lambda *_: SimpleNamespace(model=judge))
    figures = {figure.name: figure for figure in moving.measure()}
    stops = figures["human speech, moving: false stops"]
    assert stops.value == pytest.approx(1.0) and stops.target == 6.0
    (said,) = (figure for name, figure in figures.items() if "Whisper base" in name)
    assert said.value == count and said.note == "of 1 clips"


@pytest.mark.usefixtures("material")
def test_without_the_other_recogniser_only_that_is_left_out(capsys):
    names = [figure.name for figure in moving.measure()]
    assert "human speech, moving: false stops" in names
    assert not any("Whisper base" in name for name in names)
    assert "make languages" in capsys.readouterr().out


def test_without_recordings_there_are_no_figures(monkeypatch, capsys):
    monkeypatch.setattr(moving, "clips", list)
    monkeypatch.setattr(armed, "clips", list)
    monkeypatch.setattr(pieces, "measured", lambda part, plans: {"": []})
    assert moving.measure() == []
    assert "no human speech" in capsys.readouterr().out
