# SPDX-License-Identifier: BSD-3-Clause
"""What `make bench` measures by name, and what each part is of."""

import importlib.util

import pytest

from bench import __main__ as main_module
from bench.catalogue import measurable, named, parts
from bench.common.part import Part
from support import product_code
from support.figures import Figure


def ran_by(words, monkeypatch):
    """Files of the parts that words measure, in their order."""
    ran = []
    monkeypatch.setattr(main_module, "run", lambda file, *_: ran.append(file) or [])
    monkeypatch.setattr(main_module, "PLACE", None)  # no page is written
    monkeypatch.setattr(main_module, "_by_itself", lambda name: main_module.main([name]))
    monkeypatch.setattr(main_module, "_decisions", lambda part: "")  # nothing is listened to
    assert main_module.main(words) == 0
    return ran


def test_an_unknown_name_is_refused_and_nothing_is_measured(capsys, monkeypatch):
    monkeypatch.setattr(main_module, "run", lambda *_: pytest.fail("measured"))
    for name, allowed in [
        ("voice.nonsense", "voice.armed"),
        ("nonsense.near", "safety"),
        ("motion.near", "motion"),
        ("paper", "system"),
    ]:
        assert main_module.main(["motion", name]) == 2
        said, _, listed = capsys.readouterr().out.partition("; allowed: ")
        assert name in said
        assert allowed in listed.rstrip().split(", ")


def test_it_says_how_it_is_used_and_measures_nothing(capsys, monkeypatch):
    monkeypatch.setattr(main_module, "run", lambda *_: pytest.fail("measured"))
    with pytest.raises(SystemExit, match="0"):
        main_module.main(["--help"])
    assert "usage: make bench" in capsys.readouterr().out


def test_a_part_or_a_family_is_measured_once_however_often_it_is_named(monkeypatch):
    assert ran_by(["voice.near"], monkeypatch) == ["voice/near"]
    family = ran_by(["sessions", "sessions.flood", "motion"], monkeypatch)
    assert family == ["sessions/flood", "sessions/reading", "motion"]
    assert len(ran_by([], monkeypatch)) == len(measurable())


def test_of_several_parts_each_has_a_process_and_one_that_fails_leaves_the_others(monkeypatch):
    calls = []

    def call(command):
        calls.append(command[1:])
        return -9 if len(calls) == 1 else 0  # killed

    monkeypatch.setattr(main_module.subprocess, "call", call)
    assert main_module.main(["sessions"]) == 1
    assert calls == [["-m", "bench", name] for name in ("sessions.flood", "sessions.reading")]


@pytest.mark.parametrize("part", measurable().values(), ids=lambda part: part.name)
def test_a_part_has_its_module_and_says_which_code_it_is_of(part):
    assert importlib.util.find_spec(f"bench.{part.place.partition(':')[0]}")
    assert part.rooms and len(product_code.identity(part.rooms)) == product_code.LENGTH


@pytest.mark.parametrize(
    ("name", "room"),
    [
        ("safety.network", "/launch/two_hosts.yaml"),
        ("safety.network", "typed_config"),
        ("safety.stops_system", "typed_config"),
        ("safety.hang", "typed_config"),
        ("system.cost", "typed_config"),
        ("paper", "typed_config"),
        ("speaker", "voice_assist/audio"),
    ],
)
def test_what_decides_a_figure_is_among_the_rooms_of_its_part(name, room):
    (part,) = [part for part in parts() if part.name == name]
    assert room in part.rooms


def test_each_bench_has_a_digest_and_one_that_is_gone_has_none():
    for part in parts():
        assert len(part.bench) == (0 if part.last_in else product_code.LENGTH), part.name


def test_no_two_parts_share_a_name():
    names = [part.name for part in parts()]
    assert len(set(names)) == len(names)
    assert not named("")


def test_details_are_left_to_the_file_and_so_is_what_a_result_rests_on():
    part = Part("a.b", "", "", (), details=(r" p95$",))
    shown = [part.is_shown(Figure(name, 1.0, "s")) for name in ("time p50", "time p95", "measured")]
    assert shown == [True, False, False]
    assert part.file == "a/b"
