# SPDX-License-Identifier: BSD-3-Clause
"""The summary of safety tells what was measured, when, and what was not."""

from rich.console import Console

from bench.safety.summary import gather
from support import figures
from support.figures import Figure


def test_each_part_is_told_with_its_date_and_its_figures(tmp_path, monkeypatch):
    monkeypatch.setattr(figures, "RESULTS", tmp_path)
    monkeypatch.setattr(figures, "ROOT", tmp_path)
    measured = [Figure("lost", 3, "", 0.0, note="(the first)"), Figure("load", 7.5, "")]
    figures.run("safety/losses", lambda: measured, Console(quiet=True))
    was, lost, load = gather(tmp_path / "safety", ["losses"])
    assert was.is_met and was.name == "losses: was measured" and "load" in was.note
    assert (lost.name, lost.value, lost.is_met) == ("losses: lost", 3, False)
    assert lost.note == "(the first)"
    assert (load.name, load.is_met) == ("losses: load", None)


def test_a_part_that_was_never_measured_misses_its_target(tmp_path):
    (never,) = gather(tmp_path, ["soak"])
    assert never.name == "soak: was measured"
    assert never.is_met is False
