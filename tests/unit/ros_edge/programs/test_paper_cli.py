# SPDX-License-Identifier: BSD-3-Clause
"""What `make paper` refuses, it refuses in one sentence before a session is played."""

import pytest

from paper import __main__ as paper


@pytest.fixture(autouse=True)
def _nothing_is_played(monkeypatch):
    for name in ("_play_all", "_press_all", "_conclude"):
        monkeypatch.setattr(paper, name, lambda *_: pytest.fail("played"))
    monkeypatch.setattr(paper, "chosen_voices", lambda *_: ())


def test_a_folder_that_cannot_be_made_is_named(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "1000")
    (tmp_path / "file").touch()
    assert paper.main(["--repetitions", "1", "--out", str(tmp_path / "file")]) == 2
    words = f"The folder of the sessions cannot be made: {tmp_path}/file: File exists\n"
    assert capsys.readouterr().out == words


@pytest.mark.parametrize("inputs", ["voice,voice", "pedal,voice,pedal", "mouse", ""])
def test_inputs_are_voice_pedal_or_each_once(capsys, inputs):
    with pytest.raises(SystemExit, match="2"):
        paper.main(["--input", inputs])
    assert "allowed are voice, pedal and voice,pedal" in capsys.readouterr().err
