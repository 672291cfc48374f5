# SPDX-License-Identifier: BSD-3-Clause
"""What the demo and its film refuse, they refuse in one sentence before anything is started."""

import pytest

from demo import __main__ as demo
from demo import film


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
