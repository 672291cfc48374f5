# SPDX-License-Identifier: BSD-3-Clause
"""What `make paper` refuses, and which of its results are full and of the present code."""

import json

import pytest
from rich.console import Console

from paper import __main__ as paper
from paper.config import load_experiment
from paper.folders import finish, note_code, settings_of
from paper.judging.outcomes import PhraseOutcome, keep

CONCLUDE = paper._conclude
NOW = "the present code"


@pytest.fixture(autouse=True)
def _nothing_is_played(monkeypatch):
    for name in ("_play_all", "_press_all", "_conclude"):
        monkeypatch.setattr(paper, name, lambda *_: pytest.fail("played"))
    monkeypatch.setattr(paper, "installed_voices", lambda _: frozenset())  # each would speak
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


def play(folder, command="stop"):
    """A session that is there."""
    folder.mkdir(exist_ok=True)
    keep(folder, [PhraseOutcome(command, command, (command,), "", True, True, 0.3, 0.5)])


@pytest.mark.parametrize(
    ("finished", "input_", "repetitions", "result"),
    [
        (4, "voice", 30, "paper.json"),
        (4, "voice", 8, ""),
        (3, "voice", 30, ""),
        (0, "pedal", 30, ""),
        (4, "pedal", 30, "paper.json"),
    ],
)
def test_a_result_that_is_kept_has_every_voice_with_all_repetitions(
    tmp_path, monkeypatch, finished, input_, repetitions, result
):
    config, concluded = load_experiment(), []
    voices = config.voices[:4]
    for voice in voices[:finished]:
        play(tmp_path / voice.name)
        finish(tmp_path / voice.name, settings_of(config, voice, repetitions))
    for name in ("_play_all", "_press_all"):
        monkeypatch.setattr(paper, name, lambda *_: 0)
    monkeypatch.setattr(paper, "chosen_voices", lambda *_: voices)
    monkeypatch.setattr(paper, "_conclude", lambda *given: concluded.append(given[2]))
    words = ["--input", input_, "--repetitions", str(repetitions), "--out", str(tmp_path)]
    assert paper.main(words) == 0
    assert concluded == [result]


@pytest.mark.parametrize(
    ("codes", "code"), [((NOW, NOW), NOW), ((NOW, "older"), "several"), ((NOW, ""), "several")]
)
def test_kept_sessions_of_other_code_are_said_to_be(tmp_path, monkeypatch, codes, code):
    voices = load_experiment().voices[:2]
    for voice, of in zip(voices, codes, strict=True):
        play(tmp_path / voice.name)
        if of:
            note_code(tmp_path / voice.name, of)
    monkeypatch.setattr(paper, "keys", lambda *_: {"code": NOW})
    monkeypatch.setattr(paper, "_report", lambda *_: None)
    CONCLUDE(voices, tmp_path, False, Console())
    assert json.loads((tmp_path / "paper.json").read_text())["code"] == code
