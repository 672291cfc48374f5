# SPDX-License-Identifier: BSD-3-Clause
"""The key of kept measurements: decisions and settings make it, names and places do not."""

import importlib.util
from dataclasses import make_dataclass
from functools import cache
from pathlib import Path

import pytest

from bench.common import resumable
from bench.voice.hearing import fingerprint

DECIDED = [[["stop", True, "spotter", "stop", 0.9]], [], [["", False, "recognizer", "shop", 0.2]]]


def test_a_decision_that_changes_changes_the_fingerprint():
    before = fingerprint.fingerprint(DECIDED)
    assert fingerprint.fingerprint([list(map(list, scene)) for scene in DECIDED]) == before
    for other in (
        [[["stop", False, "spotter", "stop", 0.9]], *DECIDED[1:]],
        [[["stop", True, "recognizer", "stop", 0.9]], *DECIDED[1:]],
        [[["stop", True, "spotter", "stop", 0.8]], *DECIDED[1:]],
        DECIDED[::-1],
    ):
        assert fingerprint.fingerprint(other) != before


def test_the_fingerprint_is_the_same_from_another_path_under_another_name(tmp_path):
    moved = tmp_path / "elsewhere.py"
    moved.write_text(Path(fingerprint.__file__).read_text(encoding="utf-8"))
    spec = importlib.util.spec_from_file_location("another_name", moved)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert module.fingerprint(DECIDED) == fingerprint.fingerprint(DECIDED)


def test_settings_count_by_their_values_and_not_by_their_names():
    before = make_dataclass("Settings", ["least"])(0.5)
    renamed = make_dataclass("Limits", ["min_confidence"])(0.5)
    other = make_dataclass("Settings", ["least"])(0.25)
    assert fingerprint.values(before) == fingerprint.values(renamed) != fingerprint.values(other)


CODE, MAKE = cache(fingerprint.code), fingerprint.make_recognizer


@cache
def network(model):
    return MAKE(fingerprint.load_voice_config(recognizer__model=model))


@pytest.fixture
def decided(tmp_path, monkeypatch):
    """What the pipeline decides on the fixed clips, instead of half a minute of listening.

    Code is read, and a network loaded, once for all tests.
    """
    decided = ["stop"]
    monkeypatch.setattr(fingerprint, "decisions", lambda model: list(decided))
    monkeypatch.setattr(fingerprint, "code", CODE)
    monkeypatch.setattr(fingerprint, "make_recognizer", lambda c: network(c.recognizer.model))
    monkeypatch.setattr(resumable, "CACHE", tmp_path)
    return decided


def test_code_that_decides_the_same_keeps_the_key_and_other_decisions_change_it(
    decided, monkeypatch
):
    before = fingerprint.identity.__wrapped__("embedded")
    monkeypatch.setattr(fingerprint, "code", lambda folder: "moved")
    assert fingerprint.identity.__wrapped__("embedded") == before
    monkeypatch.setattr(fingerprint, "code", lambda folder: "changed")
    decided.append("hold")
    assert fingerprint.identity.__wrapped__("embedded") != before


def test_decisions_are_made_anew_by_other_code_of_the_pipeline_that_really_runs(
    decided, monkeypatch
):
    seen = []
    monkeypatch.setattr(fingerprint, "code", lambda folder: seen.append(folder) or "x")
    fingerprint.identity.__wrapped__("embedded")
    assert (seen[0] / "pipeline" / "pipeline.py").is_file()


def identity_with(monkeypatch, **changes):
    plain = fingerprint.load_voice_config
    monkeypatch.setattr(
        fingerprint, "load_voice_config", lambda *a, **k: plain(*a, **{**changes, **k})
    )
    return fingerprint.identity.__wrapped__("embedded")


@pytest.mark.parametrize("change", ["spotter__alone", "recognizer__early__settle"])
def test_another_setting_gives_another_key(decided, monkeypatch, change):
    before = fingerprint.identity.__wrapped__("embedded")
    assert identity_with(monkeypatch, **{change: 0.0625}) != before


def test_how_long_the_node_lets_recognition_hang_is_no_part_of_the_key(decided, monkeypatch):
    before = fingerprint.identity.__wrapped__("embedded")
    assert identity_with(monkeypatch, recognizer__hung_after=0.125) == before
