# SPDX-License-Identifier: BSD-3-Clause
"""What the demo and its film refuse, they refuse in one sentence before anything is started."""

from types import SimpleNamespace

import pytest

from demo import __main__ as demo
from demo import film

SESSION = demo._session


@pytest.fixture(autouse=True)
def _nothing_is_started(monkeypatch):
    monkeypatch.setattr(demo, "_session", lambda *_: pytest.fail("started"))
    monkeypatch.setenv("COLUMNS", "1000")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, "script.yaml is 'No such file or directory', allowed: a readable file"),
        (b"", "script.yaml is None, allowed: a mapping of keys to values"),
        (b"\xff\x00", "script.yaml is "),
    ],
)
def test_a_script_that_is_none_is_named(tmp_path, capsys, content, words):
    script = tmp_path / "script.yaml"
    if content is not None:
        script.write_bytes(content)
    assert demo.main(["--script", str(script), "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().out
    assert words in said and said.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("other", ["--wav", "--film"])
def test_a_microphone_leaves_no_place_for_the_script(capsys, other):
    with pytest.raises(SystemExit, match="2"):
        demo.main([other, "--microphone"])
    assert "--microphone is not allowed with --wav or --film" in capsys.readouterr().err


def test_a_film_needs_a_recording(tmp_path, capsys):
    assert film.main([str(tmp_path)]) == 2
    assert capsys.readouterr().err == f"no session.mcap in {tmp_path}\n"
    with pytest.raises(SystemExit, match="2"):
        film.main([])
    assert "usage: demo.film" in capsys.readouterr().err


def test_a_folder_that_holds_a_recording_is_refused(tmp_path, capsys):
    (tmp_path / "session_2.mcap").write_bytes(b"of an earlier run")
    assert demo.main(["--out", str(tmp_path)]) == 2
    assert capsys.readouterr().out == f"{tmp_path} holds a recording: name a new folder\n"


def test_a_demo_whose_folder_cannot_be_made_says_so_and_starts_nothing(tmp_path, capsys):
    (tmp_path / "file").touch()
    assert demo.main(["--out", str(tmp_path / "file" / "session")]) == 2
    said = capsys.readouterr()
    assert said.out.startswith("The folder of the session cannot be made") and said.err == ""


@pytest.mark.parametrize(("failed", "status"), [(0, 0), (1, 1)])
def test_a_report_that_fails_is_no_success_though_one_lies_there(
    tmp_path, monkeypatch, capsys, failed, status
):
    (tmp_path / "report.html").write_text("of an earlier run")

    def session(script, folder, *_):
        (folder / "session.mcap").write_bytes(b"recorded")
        return []

    done = SimpleNamespace(returncode=failed, stderr="disk full", stdout="")
    monkeypatch.setattr(demo, "_session", session)
    monkeypatch.setattr(demo.subprocess, "run", lambda *_, **__: done)
    assert demo.main(["--out", str(tmp_path)]) == status
    assert ("Did not happen: report.html" in capsys.readouterr().out) is bool(failed)


def test_the_newest_recording_of_the_folder_is_filmed(tmp_path, monkeypatch, capsys):
    for name in ("session.mcap", "session_2.mcap"):
        (tmp_path / name).write_bytes(b"recorded")
    filmed = []
    monkeypatch.setattr(film, "write_film", lambda mcap, gif: filmed.append(mcap) or 1)
    assert film.main([str(tmp_path)]) == 1
    assert filmed == [tmp_path / "session_2.mcap"]
    assert capsys.readouterr().err == f"no film.gif: 1 pictures in {filmed[0]}\n"


def test_nobody_speaks_the_script_to_who_speaks_himself(tmp_path, monkeypatch):
    def system(*_):
        raise RuntimeError("far enough")

    monkeypatch.setattr(demo, "_session", SESSION)
    monkeypatch.setattr(demo, "render", lambda *_: pytest.fail("speaks"))
    monkeypatch.setattr(demo, "System", system)
    assert demo.main(["--microphone", "--out", str(tmp_path)]) == 1
