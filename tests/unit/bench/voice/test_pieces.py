# SPDX-License-Identifier: BSD-3-Clause
"""Scenes in pieces: which are streamed, and what of them is kept beside the results."""

import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import pytest

from bench.common import resumable
from bench.voice.hearing import pieces
from bench.voice.hearing.replay_stream import SceneDecision, SceneResult, SoundScene
from voice_assist.types import Mode


@dataclass(frozen=True)
class Piece:
    seed: int

    def name(self):
        return f"piece-{self.seed}"

    def scenes(self):
        yield {"seed": self.seed}, SoundScene(np.zeros(512, np.float32), Mode.ACTIVE)


@pytest.fixture
def listened(tmp_path, monkeypatch):
    """Seeds of the scenes that were really streamed; by a listener that hears "stop"."""
    seen = []

    def hear(scene):
        seen.append(scene)
        return SceneResult(
            (SceneDecision(0.1, "stop", True, 0.9, "spotter", "stop", ""),), 0.032, 0.001, 0.032
        )

    monkeypatch.setattr(resumable, "CACHE", tmp_path)
    monkeypatch.setattr(pieces, "_pool", lambda model, jobs: ThreadPoolExecutor(jobs))
    monkeypatch.setattr(pieces, "_LISTENERS", [hear])
    monkeypatch.setattr(pieces, "identity", lambda model="": f"key-of-{model}")
    return seen


def test_only_the_pieces_that_are_not_there_are_streamed(listened):
    plan = [Piece(seed) for seed in range(3)]
    first = pieces.measured("part", {"": plan[:2]})[""]
    assert (len(first), len(listened)) == (2, 2)
    again = pieces.measured("part", {"": plan})[""]
    assert len(listened) == 3
    assert [r.label["seed"] for r in again] == [0, 1, 2]
    assert again[0].heard == first[0].heard
    assert again[0].heard.taken == ("stop",)


def test_pieces_kept_beside_the_results_are_counted_on_another_machine(
    listened, tmp_path, monkeypatch
):
    plan = [Piece(seed) for seed in range(3)]
    first = pieces.measured("part", {"": plan[:2]}, "")[""]
    kept = tmp_path / "kept"
    assert pieces.keep("part", plan, kept, "") == 2
    assert pieces.keep("part", plan, kept, "") == 0
    monkeypatch.setattr(resumable, "CACHE", tmp_path / "elsewhere")
    assert pieces.restore("part", kept, "another") == 0
    assert pieces.restore("part", kept, "") == 2
    again = pieces.measured("part", {"": plan}, "")[""]
    assert len(listened) == 3
    assert [r.heard for r in again[:2]] == [r.heard for r in first]


def test_of_a_piece_that_is_kept_only_what_was_taken_is_left(listened, tmp_path, monkeypatch):
    said = (
        SceneDecision(0.1, "stop", True, 0.9, "", "stop", ""),
        SceneDecision(0.2, "", False, 0.9, "", "a", "b"),
    )
    heard = [
        SceneResult(said[:1], 1.0, 0.1, 0.0),
        SceneResult(said, 1.0, 0.1, 0.0),
        SceneResult(said[1:], 1, 0, 0),
    ]
    turns = iter(heard)
    monkeypatch.setattr(pieces, "_LISTENERS", [lambda scene: next(turns)])
    monkeypatch.setattr(resumable, "JOBS", 1)
    plan = [Piece(seed) for seed in range(3)]
    pieces.measured("part", {"": plan}, "")
    pieces.keep("part", plan, tmp_path / "kept", "")
    monkeypatch.setattr(resumable, "CACHE", tmp_path / "elsewhere")
    pieces.restore("part", tmp_path / "kept", "")
    found = pieces.measured("part", {"": plan}, "")[""]
    assert [r.heard.taken for r in found] == [("stop",), ("stop",), ()]
    assert [len(r.heard.said) for r in found] == [1, 1, 0]
    assert next(turns, None) is None


def test_of_what_was_said_in_a_piece_that_is_kept_what_was_taken_is_left(listened, tmp_path):
    said = [(0.1, "up", "v", "a"), (1.0, "no", "w", "b"), (2.0, "go", "v", "c"), (3.0, "", "", "")]
    taken = tuple(SceneDecision(at, "stop", True, 0.9, "", "stop", "") for at in (0.05, 2.5))
    record = {"label": {"spans": said}, "heard": SceneResult(taken, 4.0, 0.1, 0.0).to_json()}
    plan = [Piece(0)]
    path = pieces.folder_of("part", "") / f"{plan[0].name()}.json"
    path.write_text(json.dumps([record]), encoding="utf-8")
    pieces.keep("part", plan, tmp_path / "kept", "")
    path.unlink()
    pieces.restore("part", tmp_path / "kept", "")
    (found,) = pieces.read(path)
    assert found.label["spans"] == [[2.0, "go", "v", "c"]]
    assert found.heard.taken == ("stop", "stop")


def test_pieces_that_other_code_heard_are_noticed(listened, tmp_path, monkeypatch):
    for code, count, is_other in (("old", 1, False), ("old", 2, False), ("new", 2, True)):
        monkeypatch.setattr(pieces, "_HEARD_BY", set())
        monkeypatch.setattr(pieces.product_code, "identity", lambda rooms, code=code: code)
        pieces.measured("part", {"": [Piece(seed) for seed in range(count)]}, "")
        assert pieces.is_of_other_code() is is_other
    pieces.keep("part", [Piece(0)], tmp_path / "kept", "")
    monkeypatch.setattr(resumable, "CACHE", tmp_path / "elsewhere")
    monkeypatch.setattr(pieces, "_HEARD_BY", set())
    pieces.restore("part", tmp_path / "kept", "")
    assert pieces.is_of_other_code()


def test_a_set_of_people_is_whole_whatever_share_is_asked_for(monkeypatch):
    monkeypatch.setattr(resumable, "SHARE", 0.25)
    assert sum(len(c.trials) for c in pieces.in_chunks(range(8), 2)) == 2
    assert sum(len(c.trials) for c in pieces.in_chunks(range(8), 2, is_whole=True)) == 8


def test_another_model_or_another_part_begins_anew(listened):
    pieces.measured("part", {"": [Piece(0)]}, "one")
    pieces.measured("part", {"": [Piece(0)]}, "one")
    assert len(listened) == 1
    pieces.measured("part", {"": [Piece(0)]}, "another")
    pieces.measured("other part", {"": [Piece(0)]}, "one")
    assert len(listened) == 3


def test_pieces_of_earlier_goes_count_beyond_those_asked_for(listened):
    plan = [Piece(seed) for seed in range(5)]
    pieces.measured("part", {"": [plan[0], plan[3]]})
    assert pieces.up_to("part", plan, 1) == [plan[0], plan[3]]
    assert pieces.up_to("part", plan, 2) == [plan[0], plan[1], plan[3]]
    assert len(listened) == 2
