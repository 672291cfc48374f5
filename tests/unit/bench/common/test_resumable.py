# SPDX-License-Identifier: BSD-3-Clause
"""Pieces and results on file: what is made again, and which result stays."""

import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

from bench.common import resumable
from support import figures
from support.figures import Figure


@pytest.fixture(autouse=True)
def _one_at_a_time(monkeypatch):
    monkeypatch.setattr(resumable, "JOBS", 1)


def carried_out(folder, names, one=str.upper):
    jobs = [(name, folder / f"{name}.json") for name in names]
    with ThreadPoolExecutor(2) as pool:
        return [p.stem for p in resumable.carried_out("part", jobs, one, pool)]


def test_pieces_that_are_there_are_not_made_again(tmp_path):
    made = []

    def one(name):
        made.append(name)
        return name.upper()

    assert sorted(carried_out(tmp_path, "ab", one)) == ["a", "b"]  # as they are done
    assert sorted(carried_out(tmp_path, "abc", one)) == ["a", "b", "c"]
    assert sorted(made) == ["a", "b", "c"]
    assert json.loads((tmp_path / "c.json").read_text()) == "C"


def test_once_the_minutes_are_over_no_piece_is_begun_and_kept_ones_still_count(
    tmp_path, monkeypatch
):
    carried_out(tmp_path, "b")
    monkeypatch.setattr(resumable, "MINUTES", 0.0)
    assert carried_out(tmp_path, "abc") == ["b"]


def test_who_has_enough_ends_the_pieces(tmp_path):
    jobs = ((n, tmp_path / f"{n}.json") for n in range(10**9))
    with ThreadPoolExecutor(1) as pool:
        some = resumable.carried_out("part", jobs, str, pool)
        assert [next(some).stem for _ in range(3)] == ["0", "1", "2"]
        some.close()


def test_a_piece_that_failed_leaves_nothing_behind(tmp_path):
    def fail(_):
        raise ValueError("no sound")

    with pytest.raises(ValueError, match="no sound"):
        carried_out(tmp_path, "a", fail)
    assert list(tmp_path.iterdir()) == []


def test_rows_of_other_keys_are_left_alone(tmp_path):
    path = tmp_path / "rows" / "part.jsonl"
    assert resumable.rows_of(path, "now") == []
    resumable.append(path, "before", {"n": 1})
    resumable.append(path, "now", {"n": float("inf")})
    assert resumable.rows_of(path, "now") == [{"n": float("inf")}]
    assert resumable.rows_of(path, "before") == [{"n": 1}]


def test_code_digest_follows_the_code_and_not_its_comments(tmp_path):
    def digest_of(text):
        (tmp_path / "a.py").write_text(text)
        return resumable.code(tmp_path)

    plain = digest_of("x = 1\n")
    assert digest_of('"""Says."""\n# why\nx  =  1\n') == plain
    assert digest_of("x = 2\n") != plain


def test_a_share_of_a_plan_is_its_beginning_and_at_least_one(monkeypatch):
    monkeypatch.setattr(resumable, "SHARE", 0.01)
    assert resumable.share_of([7, 8, 9]) == [7]
    monkeypatch.setattr(resumable, "SHARE", 1.0)
    assert resumable.share_of([7, 8, 9]) == [7, 8, 9]


# --- results on file


@pytest.fixture
def on_file(tmp_path, monkeypatch):
    monkeypatch.setattr(resumable, "PLACE", tmp_path / "results")
    monkeypatch.setattr(resumable, "ASIDE", tmp_path / "aside")
    monkeypatch.setattr(figures, "RESULTS", tmp_path / "results")
    monkeypatch.delenv("FORCE", raising=False)
    path = tmp_path / "results" / "voice" / "x.json"
    path.parent.mkdir(parents=True)
    data = {"figures": [{"name": "measured", "value": 100.0}]}
    path.write_text(json.dumps(data))
    return tmp_path


@pytest.mark.parametrize(
    ("amount", "full", "where"),
    [
        (40.0, 100.0, "aside"),
        (100.0, 100.0, "results"),
        (85.0, 90.0, "aside"),
        (95.0, 90.0, "results"),
    ],
)
def test_a_result_that_rests_on_less_is_written_aside_unless_it_is_whole(
    on_file, amount, full, where
):
    measure = resumable.kept("voice/x", lambda: [resumable.measured(amount, "h", full)])
    measure()
    assert on_file / where == figures.RESULTS


@pytest.mark.parametrize(("amount", "where"), [(10.0, "aside"), (60.0, "results")])
def test_a_result_that_does_not_say_what_it_rests_on_counts_as_whole(on_file, amount, where):
    (on_file / "results" / "voice" / "x.json").write_text(json.dumps({"figures": []}))
    resumable.kept("voice/x", lambda: [resumable.measured(amount, "s", 60.0)])()
    assert on_file / where == figures.RESULTS


def test_a_whole_result_after_a_part_goes_to_its_place_again(on_file):
    resumable.kept("voice/x", lambda: [resumable.measured(1.0, "h", 100.0)])()
    resumable.kept("voice/y", lambda: [Figure("other", 1.0, "")])()
    assert on_file / "results" == figures.RESULTS


def test_a_part_that_measured_nothing_takes_no_results_place(on_file):
    for name in ("voice/x", "voice/never measured"):
        resumable.kept(name, list)()
        assert on_file / "aside" == figures.RESULTS


def test_results_of_another_model_are_written_aside():
    words = "from bench.common.resumable import ASIDE, PLACE; print(PLACE == ASIDE)"
    for more, said in (({"MODEL": "x.pt"}, "True"), ({"MODEL": "embedded"}, "False")):
        environment = {k: v for k, v in os.environ.items() if k != "RESULTS"} | more
        command = [sys.executable, "-c", words]
        found = subprocess.run(
            command, cwd=figures.ROOT, env=environment, capture_output=True, text=True, check=True
        )
        assert found.stdout.strip() == said


def test_force_writes_whatever_is_on_file(on_file, monkeypatch):
    monkeypatch.setenv("FORCE", "1")
    assert resumable.place("voice/x.json", 1.0) == on_file / "results"


def test_details_follow_the_same_rule(on_file):
    resumable.write_details("voice/d.json", 10.0, {"fired": [1]})
    resumable.write_details("voice/d.json", 3.0, {"fired": []})
    path = on_file / "results" / "voice" / "d.json"
    assert json.loads(path.read_text()) == {"measured": 10.0, "fired": [1]}
    assert (on_file / "aside" / "voice" / "d.json").is_file()
    resumable.write_details("voice/d.json", 9.0, {"fired": [2]}, 8.0)  # whole, as its figures are
    assert json.loads(path.read_text()) == {"measured": 9.0, "fired": [2]}
