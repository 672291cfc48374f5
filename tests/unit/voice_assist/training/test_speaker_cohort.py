# SPDX-License-Identifier: BSD-3-Clause
"""A background of the speaker gate is written whole, and only if a gate can load it."""

import sys

import numpy as np
import pytest

from voice_assist.errors import ManifestError
from voice_assist.speaker.cohort import NEAREST, read_cohort
from voice_assist.speaker.network import WIDTH
from voice_assist.training import speaker_cohort
from voice_assist.types import RATE


def write_manifest(folder, speakers, head="path,kind,speaker,source,split"):
    rows = [f"{i}.wav,speech,{i},x,train" for i in range(speakers)]
    (folder / "manifest.csv").write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")


@pytest.fixture
def asked(tmp_path, monkeypatch):
    """The words that make a background of so many speakers who say enough."""
    monkeypatch.setattr(
        speaker_cohort, "VoiceNetwork", lambda: lambda _: np.ones(WIDTH) / np.sqrt(WIDTH)
    )
    sound = np.ones(6 * RATE, np.float32)

    def words(out, listed, speaking):
        write_manifest(tmp_path, listed)
        found = [(("x", str(i)), [sound]) for i in range(speaking)]
        monkeypatch.setattr(speaker_cohort, "speech_of", lambda *_: iter(found))
        return tmp_path, "--out", out

    return words


def test_it_is_written_under_the_very_name_and_a_gate_loads_it(asked, tmp_path, monkeypatch):
    (tmp_path / "out").mkdir()
    words = asked(tmp_path / "out" / "c.bin", NEAREST + 1, NEAREST + 1)
    monkeypatch.setattr(sys, "argv", ["cohort", *map(str, words)])
    speaker_cohort.main()
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["c.bin"]
    assert len(read_cohort(tmp_path / "out" / "c.bin")[0].speakers) == NEAREST + 1


@pytest.mark.parametrize(("listed", "speaking"), [(0, 0), (NEAREST, NEAREST), (NEAREST + 1, 3)])
def test_too_few_speakers_are_counted_and_the_old_file_stays(
    asked, refused, tmp_path, listed, speaking
):
    old = tmp_path / "c.npz"
    old.write_bytes(b"of the gate")
    line = f"manifest.csv: {speaking} speakers, needed: more than 100 with 5 s of speech"
    assert line in refused(speaker_cohort, *asked(old, listed, speaking))
    assert old.read_bytes() == b"of the gate"


def test_a_write_that_fails_leaves_the_old_file_alone(asked, refused, tmp_path, monkeypatch):
    (tmp_path / "out").mkdir()
    old = tmp_path / "out" / "c.npz"
    old.write_bytes(b"of the gate")

    def write(_, path):
        path.write_bytes(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(speaker_cohort, "write_cohort", write)
    refused(speaker_cohort, *asked(old, NEAREST + 1, NEAREST + 1))
    assert [path.read_bytes() for path in (tmp_path / "out").iterdir()] == [b"of the gate"]


def test_a_manifest_of_a_spreadsheet_is_read_and_a_missing_column_named(tmp_path):
    write_manifest(tmp_path, 2, head="\ufeffPath,kind,speaker,source,split")
    assert len(speaker_cohort.clips_of(tmp_path, ("train",))) == 2
    write_manifest(tmp_path, 2, head="path,kind,who,source,split")
    with pytest.raises(ManifestError, match="no column 'speaker'; columns are: path, kind, who"):
        speaker_cohort.clips_of(tmp_path, ("train",))
