# SPDX-License-Identifier: BSD-3-Clause
"""Rows of labelled clips, and which command each is of."""

import pytest
import soundfile

from tests.unit.voice_assist.support.fake_speech import say
from voice_assist.config import load_voice_config
from voice_assist.errors import ManifestError
from voice_assist.evaluation.evaluator import read_manifest
from voice_assist.types import RATE

CONFIG = load_voice_config()


def write(path, text):
    soundfile.write(path, say(text, before=0.1, after=0.1), RATE)
    return path.name


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ("", "no column 'path'"),
        ("file,transcript\na.wav,x\n", "no column 'path'; columns are: file, transcript"),
        ("path,text\na.wav,x\n", "no column 'transcript'"),
        ("path,transcript\n", "has no rows"),
        ("path,transcript\nnone.wav,stop\n", r"row 2: .*none\.wav: no such file"),
        ("path,transcript\n\n,stop\n", "row 3: the path is empty"),
        ("path,transcript\nclips.csv,stop\n", r"row 2: .*not a sound file"),
        ("path,transcript\n.,stop\n", "row 2: .*: not a file"),
    ],
)
def test_a_manifest_that_cannot_be_used_says_why(tmp_path, content, problem):
    path = tmp_path / "clips.csv"
    with pytest.raises(ManifestError, match=r"clips\.csv"):  # it is missing
        read_manifest(path, CONFIG.commands)
    path.write_text(content)
    with pytest.raises(ManifestError, match=problem):
        read_manifest(path, CONFIG.commands)


def test_a_manifest_of_a_spreadsheet_is_read(tmp_path):
    write(tmp_path / "a.wav", "stop")
    path = tmp_path / "clips.csv"
    path.write_bytes('\ufeffTranscript , Path\r\n"Stop, stop!",a.wav\r\n'.encode())
    (clip,) = read_manifest(path, CONFIG.commands)
    assert (clip.row, clip.phrase) == (2, "stop")


@pytest.mark.parametrize(
    ("said", "phrase"),
    [
        ("pull 2 mm more", "pull two millimetres more"),
        ("Pull two millimeters more!", "pull two millimetres more"),
        ("pull more", "pull more"),
        ("pull 2 inches more", ""),
    ],
)
def test_an_amount_is_labelled_as_it_is_heard(tmp_path, said, phrase):
    path = tmp_path / "clips.csv"
    path.write_text(f"path,transcript\n{write(tmp_path / 'a.wav', 'pull more')},{said}\n")
    commands = load_voice_config(commands__amounts=True).commands
    assert [clip.phrase for clip in read_manifest(path, commands)] == [phrase]
    without = phrase if phrase == said else ""
    assert [clip.phrase for clip in read_manifest(path, CONFIG.commands)] == [without]
