# SPDX-License-Identifier: BSD-3-Clause
import copy
import hashlib
import subprocess
from fractions import Fraction
from types import SimpleNamespace
from xmlrpc.client import Binary, DateTime

import pytest
import yaml

from session_log.recording import metadata
from session_log.recording.namespace import Namespace
from session_log.ros import recorder_node


@pytest.fixture
def kept(tmp_path):
    """A folder that is kept in git, with one file."""

    def git(*words):
        subprocess.run(["git", "-C", tmp_path, *words], check=True, capture_output=True)

    git("init")
    (tmp_path / "a").write_text("1")
    git("add", "a")
    git("-c", "user.name=t", "-c", "user.email=t@example.org", "commit", "-m", "first")
    return tmp_path


def test_the_commit_and_what_was_changed_since_are_named(kept):
    assert metadata.code_facts(kept)["changed_files"] == ""
    (kept / "a").write_text("2")
    facts = metadata.code_facts(kept)
    assert len(facts["commit"]) == 40 and "a" in facts["changed_files"]


@pytest.mark.parametrize(
    ("path", "found"),
    [
        ("voice_assist", {"commands": {"language": "de"}}),
        ("/voice_assist/commands", {"language": "de"}),
        ("voice_assist/commands/language", {}),
        ("voice_assist/audio", {}),
        ("none", {}),
        ("", {}),
        ("odd", {}),
    ],
)
def test_settings_are_found_by_their_path_in_what_was_recorded(path, found):
    facts = metadata.parameter_facts({"voice_assist": {"commands": {"language": "de"}}})
    assert metadata.settings_at({**facts, "odd": "[", "scalar": "3"}, path) == found


@pytest.mark.parametrize("built", ["abc123", None])
def test_a_repository_around_that_does_not_track_the_sources_is_not_theirs(
    kept, monkeypatch, built
):
    (kept / ".gitignore").write_text("ignored\n")
    if built:
        monkeypatch.setenv("VOICE_ASSIST_COMMIT", built)
    else:
        monkeypatch.delenv("VOICE_ASSIST_COMMIT", raising=False)
    for name in ("untracked", "ignored"):
        sources = kept / name / "session_log"
        sources.mkdir(parents=True)
        (sources / "package.xml").write_text("<package/>")
        assert metadata.code_facts(sources)["commit"] == (built or "unknown")


@pytest.mark.parametrize("installed", [True, False])
def test_an_install_space_has_no_repository_even_where_one_tracks_it(kept, monkeypatch, installed):
    monkeypatch.setenv("VOICE_ASSIST_COMMIT", "abc123")
    monkeypatch.setattr(recorder_node, "package_folder", lambda name: kept)
    monkeypatch.setattr(recorder_node, "repository", lambda name: None if installed else kept)
    recorded = {}
    recorder = SimpleNamespace(add_metadata=recorded.__setitem__)
    recorder_node.add_facts(recorder, SimpleNamespace(seed=0), 0, Namespace("/"))
    assert (recorded["code"]["commit"] == "abc123") is installed


def test_in_an_image_the_commit_is_the_one_it_was_built_of(tmp_path, monkeypatch):
    monkeypatch.setenv("VOICE_ASSIST_COMMIT", "abc123")
    assert metadata.code_facts(tmp_path) == {"commit": "abc123", "changed_files": ""}


def test_outside_a_repository_the_commit_and_its_changes_are_unknown(tmp_path, monkeypatch):
    monkeypatch.delenv("VOICE_ASSIST_COMMIT", raising=False)
    assert metadata.code_facts(tmp_path) == {"commit": "unknown", "changed_files": "unknown"}


def test_a_named_file_gets_its_hash_beside_it(tmp_path):
    (tmp_path / "model.pt").write_bytes(b"weights")
    facts = metadata.named_facts({"model": str(tmp_path / "model.pt"), "seed": 7})
    assert facts["model_sha256"] == hashlib.sha256(b"weights").hexdigest()
    assert facts["seed"] == "7"


def test_parameters_become_text_without_the_urdf():
    facts = metadata.parameter_facts({"b": {"x": 1}, "a": 2, "robot_description": "<robot/>"})
    assert list(facts) == ["a", "b"] and facts["b"] == "x: 1"


def test_the_machine_is_described_without_empty_fields():
    assert all(metadata.machine_facts().values())


def test_versions_leave_out_what_is_not_installed():
    assert list(metadata.version_facts(["mcap", "no-such-package-at-all"])) == ["mcap"]


def test_changes_that_git_does_not_report_in_time_are_unknown(tmp_path, monkeypatch):
    def answer(words, **options):
        if "status" in words:
            raise subprocess.TimeoutExpired(words, options["timeout"])
        return subprocess.CompletedProcess(words, 0, stdout="abc123")

    monkeypatch.setattr(metadata.subprocess, "run", answer)
    assert metadata.code_facts(tmp_path) == {"commit": "abc123", "changed_files": "unknown"}


def test_dates_binary_data_and_unknown_types_cost_no_other_parameter():
    date, odd = DateTime("20261121T09:30:00"), Fraction(1, 3)
    values = {"a": {"day": date, "all": [date]}, "b": Binary(b"\0\xff"), "c": 2, "d": odd}
    facts = metadata.parameter_facts(values)
    day = "20261121T09:30:00"
    found = {key: yaml.safe_load(text) for key, text in facts.items()}
    assert found == {"a": {"day": day, "all": [day]}, "b": b"\0\xff", "c": 2, "d": "1/3"}


class Wordless:
    def __str__(self):
        raise ValueError("no words\nfor it")


def test_a_parameter_that_cannot_be_written_has_the_reason_in_its_place():
    facts = metadata.parameter_facts({"bad": Wordless(), "good": 1})
    assert facts["good"].startswith("1")
    assert facts["bad"] == f"{metadata.NOT_RECORDED}ValueError: no words for it"
    assert yaml.safe_load(facts["bad"]) is None


def test_a_value_too_long_for_a_path_names_no_file():
    words = "/" + "x" * 5000
    assert metadata.named_facts({"robot": words}) == {"robot": words}


@pytest.fixture
def watched(monkeypatch):
    """What is recorded, offered and warned of where the master answers so."""

    def check(ask_master):
        recorded, offered, warned = {}, [], []
        recorder = SimpleNamespace(
            register=lambda source: source,
            add_metadata=recorded.__setitem__,
            offer=lambda tally, data: offered.append(data[4:]),
        )
        monkeypatch.setattr(recorder_node, "ask_master", ask_master)
        warn = lambda _, words, *parts: warned.append(words % parts)  # noqa: E731
        monkeypatch.setattr(recorder_node.rospy, "logwarn_throttle", warn)
        recorder_node.ParameterWatcher(recorder, Namespace("/")).check()
        return recorded, offered, warned

    return check


def test_one_odd_parameter_costs_neither_the_others_nor_the_robot(watched):
    parameters = {"bad": Wordless(), "day": DateTime("20261121T09:30:00"), "gain": 1}
    parameters |= {"session": {"voice": {"seed": 7}}, "robot_description": "<robot/>"}
    recorded, offered, warned = watched(lambda method, name: parameters)
    assert set(recorded["parameters"]) == {"bad", "day", "gain"}
    assert recorded["session/voice"] == {"seed": "7"} and offered == [b"<robot/>"]
    assert len(warned) == 1 and "/bad: ValueError" in warned[0]


def test_a_master_whose_answer_breaks_off_costs_no_turn_of_the_recorder(watched):
    def broken(method, name):
        raise EOFError("Compressed file ended before the end-of-stream marker was reached")

    recorded, offered, warned = watched(broken)
    assert recorded == {} and offered == [] and "parameters" in warned[0]


def test_what_did_not_change_is_hashed_and_written_out_once(monkeypatch, tmp_path):
    """The heartbeat waits for it, and large files take long."""
    weights, hashed, recorded = tmp_path / "weights.pt", [], []
    weights.write_bytes(b"large")
    file_hash = metadata.file_hash
    monkeypatch.setattr(metadata, "file_hash", lambda path: hashed.append(path) or file_hash(path))
    recorder = SimpleNamespace(
        register=lambda source: source,
        add_metadata=lambda name, values: recorded.append(name),
        offer=lambda tally, data: None,
    )
    parameters = {"day": DateTime("20261121T09:30:00"), "model": Binary(b"x"), "gain": 1}
    parameters |= {"session": {"mine": {"weights": str(weights)}}}
    monkeypatch.setattr(recorder_node, "ask_master", lambda *_: copy.deepcopy(parameters))
    watcher = recorder_node.ParameterWatcher(recorder, Namespace("/"))
    for _ in range(3):
        watcher.check()
    assert hashed == [weights] and recorded == ["parameters", "session/mine"]
    parameters["model"] = Binary(b"y")
    watcher.check()
    assert hashed == [weights] and recorded == ["parameters", "session/mine", "parameters"]
