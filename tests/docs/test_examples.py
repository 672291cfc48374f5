# SPDX-License-Identifier: BSD-3-Clause
"""The examples print what they are meant to show, or say in one line why they cannot."""

import io
import re
import runpy
import subprocess
import sys
from contextlib import redirect_stdout
from pathlib import Path

import numpy as np
import pytest
import soundfile

from support.story import write_session
from support.theatre_sound import RATE, speak

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
LONGEST = 40  # lines


def run(name, *words):
    """What an example prints in this process, which imports what it needs once for all."""
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(io.StringIO()) as printed:
        patch.setattr(sys, "argv", [name, *map(str, words)])
        runpy.run_path(str(EXAMPLES / name), run_name="__main__")
    return printed.getvalue()


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.name)
def test_an_example_is_short(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= LONGEST


def test_the_planned_way_through_the_trocar_keeps_the_shaft_in_it():
    output = run("plan_through_trocar.py")
    paths = re.findall(r"path \d: ([\d.]+) mm, RCM error ([\d.]+) um", output)
    allowed = float(re.search(r"allowed ([\d.]+) um", output)[1])
    assert len(paths) >= 3
    assert all(float(length) > 10.0 for length, _ in paths)
    assert all(float(error) < allowed for _, error in paths)


def test_the_simulated_robot_grasps_pulls_and_lets_go():
    output = run("move_simulated_robot.py")
    ends = re.findall(
        r'"([a-z ]+)": .*, (\w+)\n  tension ([\d.]+) N, RCM error ([\d.]+) um', output
    )
    assert [(words, end) for words, end, *_ in ends] == [
        ("hey robot", "succeeded"),
        ("tense", "succeeded"),
        ("release", "succeeded"),
    ]
    tensions = [float(tension) for *_, tension, _ in ends]
    assert tensions == pytest.approx([0.0, 1.0, 0.0], abs=0.05)
    assert max(float(error) for *_, error in ends) < 50.0


def test_a_session_is_read_into_columns(tmp_path):
    write_session(tmp_path / "session.mcap", rate=20)
    output = run("session_to_data_frame.py", tmp_path)
    assert "'tense' was taken for 'tense'" in output and "'stop' was taken for 'stop'" in output
    error = float(re.search(r"RCM error inside the patient: ([\d.]+) um", output)[1])
    assert 1.0 < error < 100.0


def test_a_command_in_a_sound_file_would_be_given_and_talk_would_not(tmp_path):
    talk, command = (speak(t, "en-us", 150) for t in ("the patient is stable", "pull more"))
    quiet = np.zeros(2 * RATE, np.float32)
    soundfile.write(tmp_path / "said.wav", np.concatenate([talk, quiet, command]), RATE)
    output = run("what_would_be_commanded.py", tmp_path / "said.wav")
    nothing, given = r".*: nothing, no_command: WER .*", r"'pull more.*': 'pull more', confidence"
    assert re.fullmatch(rf"{nothing}\n{given} 0\.\d\d\n", output), output


def test_an_example_that_cannot_go_on_ends_with_status_1_and_one_line():
    command = [sys.executable, EXAMPLES / "session_to_data_frame.py", "no.mcap"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (1, "no.mcap: no such file or folder\n")


@pytest.mark.parametrize(
    ("example", "words", "said"),
    [
        ("session_to_data_frame.py", [], ".: a folder without session.mcap"),
        ("session_to_data_frame.py", ["no.mcap"], "no.mcap: no such file or folder"),
        ("session_to_data_frame.py", ["cut.mcap"], "cut.mcap: no utterance or no state was"),
        ("what_would_be_commanded.py", [], "what_would_be_commanded.py needs a sound file"),
        ("what_would_be_commanded.py", ["no.wav"], "no.wav: no such file"),
        ("what_would_be_commanded.py", ["--help"], "--help: no such file"),
    ],
)
def test_what_an_example_cannot_read_is_said_in_one_line(
    tmp_path, monkeypatch, capfd, example, words, said
):
    write_session(tmp_path / "whole.mcap", duration=-1.0)
    whole = (tmp_path / "whole.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[:20])
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as end:
        run(example, *words)
    code = end.value.code  # words, which Python prints, and ends with status 1
    assert isinstance(code, str) and code.startswith(said) and "\n" not in code
    assert capfd.readouterr().err == ""
