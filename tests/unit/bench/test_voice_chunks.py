# SPDX-License-Identifier: BSD-3-Clause
"""Pieces that are kept: what is done again, what is not, and which result stays on file."""

import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import pytest

from bench.voice import (
    fingerprint,
    held_out_voices,
    merge_results,
    mixing,
    resumable,
    resumable_archive,
)
from bench.voice.held_out_voices import Voice, spread
from bench.voice.mixing import Trial, stream_of, twice
from bench.voice.replay_stream import Heard, Said, Scene
from bench.voice.synthesis import Spoken
from support import figures
from support.figures import Figure
from voice_assist.types import RATE, Mode


@dataclass(frozen=True)
class Piece:
    seed: int

    def name(self):
        return f"piece-{self.seed}"

    def scenes(self):
        yield {"seed": self.seed}, Scene(np.zeros(512, np.float32), Mode.ACTIVE)


@pytest.fixture
def listened(tmp_path, monkeypatch):
    """Seeds of the scenes that were really streamed; by a listener that hears "stop"."""
    seen = []

    def hear(scene):
        seen.append(scene)
        return Heard((Said(0.1, "stop", True, 0.9, "spotter", "stop", ""),), 0.032, 0.001, 0.032)

    monkeypatch.setattr(resumable.clips, "CACHE", tmp_path)
    monkeypatch.setattr(resumable, "_pool", lambda model, jobs: ThreadPoolExecutor(jobs))
    monkeypatch.setattr(resumable, "_LISTENERS", [hear])
    monkeypatch.setattr(resumable, "identity", lambda model="": f"key-of-{model}")
    return seen


def test_only_the_pieces_that_are_not_there_are_streamed(listened):
    plan = [Piece(seed) for seed in range(3)]
    first = resumable.measured("part", {"": plan[:2]})[""]
    assert (len(first), len(listened)) == (2, 2)
    again = resumable.measured("part", {"": plan})[""]
    assert len(listened) == 3
    assert [r.label["seed"] for r in again] == [0, 1, 2]
    assert again[0].heard == first[0].heard
    assert again[0].heard.taken == ("stop",)


def test_pieces_kept_beside_the_results_are_counted_on_another_machine(
    listened, tmp_path, monkeypatch
):
    plan = [Piece(seed) for seed in range(3)]
    first = resumable.measured("part", {"": plan[:2]}, "")[""]
    kept = tmp_path / "kept"
    assert resumable_archive.keep("part", plan, kept, "") == 2
    assert resumable_archive.keep("part", plan, kept, "") == 0
    monkeypatch.setattr(resumable.clips, "CACHE", tmp_path / "elsewhere")
    assert resumable_archive.restore("part", kept, "another") == 0
    assert resumable_archive.restore("part", kept, "") == 2
    again = resumable.measured("part", {"": plan}, "")[""]
    assert len(listened) == 3
    assert [r.heard for r in again[:2]] == [r.heard for r in first]


def test_of_a_piece_that_is_kept_only_what_was_taken_is_left(listened, tmp_path, monkeypatch):
    said = (Said(0.1, "stop", True, 0.9, "", "stop", ""), Said(0.2, "", False, 0.9, "", "a", "b"))
    heard = [Heard(said[:1], 1.0, 0.1, 0.0), Heard(said, 1.0, 0.1, 0.0), Heard(said[1:], 1, 0, 0)]
    turns = iter(heard)
    monkeypatch.setattr(resumable, "_LISTENERS", [lambda scene: next(turns)])
    monkeypatch.setattr(resumable, "JOBS", 1)
    plan = [Piece(seed) for seed in range(3)]
    resumable.measured("part", {"": plan}, "")
    resumable_archive.keep("part", plan, tmp_path / "kept", "")
    monkeypatch.setattr(resumable.clips, "CACHE", tmp_path / "elsewhere")
    resumable_archive.restore("part", tmp_path / "kept", "")
    found = resumable.measured("part", {"": plan}, "")[""]
    assert [r.heard.taken for r in found] == [("stop",), ("stop",), ()]
    assert [len(r.heard.said) for r in found] == [1, 1, 0]
    assert next(turns, None) is None


def test_of_what_was_said_in_a_piece_that_is_kept_what_was_taken_is_left(listened, tmp_path):
    said = [(0.1, "up", "v", "a"), (1.0, "no", "w", "b"), (2.0, "go", "v", "c"), (3.0, "", "", "")]
    taken = tuple(Said(at, "stop", True, 0.9, "", "stop", "") for at in (0.05, 2.5))
    record = {"label": {"spans": said}, "heard": Heard(taken, 4.0, 0.1, 0.0).to_json()}
    plan = [Piece(0)]
    path = resumable.folder_of("part", "") / f"{plan[0].name()}.json"
    path.write_text(json.dumps([record]), encoding="utf-8")
    resumable_archive.keep("part", plan, tmp_path / "kept", "")
    path.unlink()
    resumable_archive.restore("part", tmp_path / "kept", "")
    (found,) = resumable.read(path)
    assert found.label["spans"] == [[2.0, "go", "v", "c"]]
    assert found.heard.taken == ("stop", "stop")


def test_another_model_or_another_part_begins_anew(listened):
    resumable.measured("part", {"": [Piece(0)]}, "one")
    resumable.measured("part", {"": [Piece(0)]}, "one")
    assert len(listened) == 1
    resumable.measured("part", {"": [Piece(0)]}, "another")
    resumable.measured("other part", {"": [Piece(0)]}, "one")
    assert len(listened) == 3


def test_no_piece_is_begun_once_the_minutes_are_over(listened, monkeypatch):
    monkeypatch.setattr(resumable, "MINUTES", 0.0)
    monkeypatch.setattr(resumable, "JOBS", 2)
    plan = [Piece(seed) for seed in range(9)]
    assert len(resumable.measured("part", {"": plan})[""]) == 2
    assert len(resumable.measured("part", {"": plan})[""]) == 4
    assert len(listened) == 4


def test_a_piece_that_failed_leaves_nothing_behind(listened, monkeypatch):
    def fail(_):
        raise ValueError("no sound")

    monkeypatch.setattr(resumable, "_LISTENERS", [fail])
    with pytest.raises(ValueError, match="no sound"):
        resumable.measured("part", {"": [Piece(0)]})
    monkeypatch.setattr(resumable, "_LISTENERS", [lambda _: Heard((), 1.0, 0.1, 1.0)])
    assert len(resumable.measured("part", {"": [Piece(0)]})[""]) == 1
    assert listened == []


def test_pieces_of_earlier_goes_count_beyond_those_asked_for(listened):
    plan = [Piece(seed) for seed in range(5)]
    resumable.measured("part", {"": [plan[0], plan[3]]})
    assert resumable.up_to("part", plan, 1) == [plan[0], plan[3]]
    assert resumable.up_to("part", plan, 2) == [plan[0], plan[1], plan[3]]
    assert len(listened) == 2


def test_code_digest_follows_the_code_and_not_its_comments(tmp_path):
    def digest_of(text):
        (tmp_path / "a.py").write_text(text)
        return resumable.code(tmp_path)

    plain = digest_of("x = 1\n")
    assert digest_of('"""Says."""\n# why\nx  =  1\n') == plain
    assert digest_of("x = 2\n") != plain


@pytest.fixture
def decided(tmp_path, monkeypatch):
    """What the pipeline decides on the fixed clips, instead of half a minute of listening."""
    decided = ["stop"]
    monkeypatch.setattr(fingerprint, "decisions", lambda model: list(decided))
    monkeypatch.setattr(resumable.clips, "CACHE", tmp_path)
    return decided


def test_code_that_decides_the_same_keeps_the_key_and_other_decisions_change_it(
    decided, monkeypatch
):
    before = resumable.identity.__wrapped__("embedded")
    monkeypatch.setattr(resumable, "code", lambda folder: "moved")
    assert resumable.identity.__wrapped__("embedded") == before
    monkeypatch.setattr(resumable, "code", lambda folder: "changed")
    decided.append("hold")
    assert resumable.identity.__wrapped__("embedded") != before


def test_decisions_are_made_anew_by_other_code_of_the_pipeline_that_really_runs(
    decided, monkeypatch
):
    seen = []
    monkeypatch.setattr(resumable, "code", lambda folder: seen.append(folder) or "x")
    resumable.identity.__wrapped__("embedded")
    assert (seen[0] / "pipeline" / "pipeline.py").is_file()


def identity_with(monkeypatch, **changes):
    plain = resumable.load_voice_config
    monkeypatch.setattr(
        resumable, "load_voice_config", lambda *a, **k: plain(*a, **{**changes, **k})
    )
    return resumable.identity.__wrapped__("embedded")


@pytest.mark.parametrize("change", ["spotter__alone", "recognizer__early__settle"])
def test_another_setting_gives_another_key(decided, monkeypatch, change):
    before = resumable.identity.__wrapped__("embedded")
    assert identity_with(monkeypatch, **{change: 0.0625}) != before


def test_how_long_the_node_lets_recognition_hang_is_no_part_of_the_key(decided, monkeypatch):
    before = resumable.identity.__wrapped__("embedded")
    assert identity_with(monkeypatch, recognizer__hung_after=0.125) == before


# --- results on file


@pytest.fixture
def on_file(tmp_path, monkeypatch):
    monkeypatch.setattr(merge_results, "PLACE", tmp_path / "results")
    monkeypatch.setattr(merge_results, "ASIDE", tmp_path / "aside")
    monkeypatch.setattr(figures, "RESULTS", tmp_path / "results")
    monkeypatch.delenv("FORCE", raising=False)
    path = tmp_path / "results" / "voice" / "x.json"
    path.parent.mkdir(parents=True)
    data = {"figures": [{"name": "measured", "value": 100.0}]}
    path.write_text(json.dumps(data))
    return tmp_path


@pytest.mark.parametrize(("amount", "where"), [(40.0, "aside"), (100.0, "results")])
def test_a_result_that_rests_on_less_is_written_aside(on_file, amount, where):
    measure = merge_results.kept("x", lambda: [merge_results.measured(amount, "h", 100.0)])
    measure()
    assert on_file / where == figures.RESULTS


def test_a_whole_result_after_a_part_goes_to_its_place_again(on_file):
    merge_results.kept("x", lambda: [merge_results.measured(1.0, "h", 100.0)])()
    merge_results.kept("y", lambda: [Figure("other", 1.0, "")])()
    assert on_file / "results" == figures.RESULTS


def test_force_writes_whatever_is_on_file(on_file, monkeypatch):
    monkeypatch.setenv("FORCE", "1")
    assert merge_results.place("voice/x.json", 1.0) == on_file / "results"


def test_details_follow_the_same_rule(on_file):
    merge_results.write_details("d", 10.0, {"fired": [1]})
    merge_results.write_details("d", 3.0, {"fired": []})
    path = on_file / "results" / "voice" / "d.json"
    assert json.loads(path.read_text()) == {"measured": 10.0, "fired": [1]}
    assert (on_file / "aside" / "voice" / "d.json").is_file()


# --- plans and sounds


def test_every_voice_says_every_text_equally_often():
    cast = [Voice("pico", "en-US"), Voice("espeak", "b"), Voice("mbrola", "mb-us1")]
    prompts = spread(("tense", "release"), cast, 3, 1)
    count = {}
    for p in prompts:
        count[p.engine, p.voice, p.text] = count.get((p.engine, p.voice, p.text), 0) + 1
        assert 0.85 <= p.rate <= 1.2
    assert set(count.values()) == {3}
    assert len(count) == 6
    assert prompts == spread(("tense", "release"), cast, 3, 1)


def test_voices_that_cannot_speak_are_named_and_left_out(monkeypatch, capsys):
    monkeypatch.setattr(held_out_voices, "_speaks", lambda voice: voice.engine != "pico")
    cast = held_out_voices._sorted_out([Voice("pico", "en-US"), Voice("espeak", "b")])
    assert cast.present == (Voice("espeak", "b"),)
    assert cast.missing == (Voice("pico", "en-US"),)
    assert "pico:en-US" in capsys.readouterr().out


@pytest.fixture
def beep(tmp_path, monkeypatch):
    import soundfile

    monkeypatch.setattr(mixing, "ROOT", tmp_path)
    t = np.arange(RATE // 2) / RATE
    for name in "abc":
        soundfile.write(tmp_path / f"{name}.wav", 0.5 * np.sin(2 * np.pi * 440 * t), RATE)
    return [Spoken(f"{name}.wav", "stop", "pico", "en-US") for name in "abc"]


def test_twice_means_another_take_of_the_same_voice_after_a_short_gap(beep):
    trials = twice(beep)
    assert [(t.clip.path, t.again.path) for t in trials] == [
        ("a.wav", "b.wav"),
        ("b.wav", "c.wav"),
        ("c.wav", "a.wav"),
    ]
    sound, end, seconds = stream_of(trials[0])
    assert end == pytest.approx(1.0, abs=0.02)
    assert 1.1 <= seconds <= 1.4
    loud = np.abs(sound) > 0.05
    assert not loud[round(1.02 * RATE) : round(1.09 * RATE)].any()
    assert loud[round((seconds + 0.4) * RATE) : round((seconds + 0.45) * RATE)].any()


def test_background_lies_as_far_below_the_speech_as_asked_for(beep):
    quiet, _, _ = stream_of(Trial(beep[0], 3))
    noisy, _, _ = stream_of(Trial(beep[0], 3, background="servo", snr=10.0))
    noise = np.asarray(noisy, np.float64) - quiet
    ratio = 0.125 / np.mean(noise**2)
    assert 10 * np.log10(ratio) == pytest.approx(10.0, abs=0.3)


def test_a_share_of_a_plan_is_its_beginning_and_at_least_one(monkeypatch):
    monkeypatch.setattr(resumable, "SHARE", 0.01)
    assert resumable.share_of([7, 8, 9]) == [7]
    monkeypatch.setattr(resumable, "SHARE", 1.0)
    assert resumable.share_of([7, 8, 9]) == [7, 8, 9]
