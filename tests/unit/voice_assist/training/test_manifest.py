# SPDX-License-Identifier: BSD-3-Clause
"""Manifests of recordings, as people write them."""

import pytest

from tests.unit.voice_assist.support.records import SPEECH_HEAD as HEAD
from voice_assist.errors import ManifestError
from voice_assist.training.data.human import ManifestRow, read_manifest


def test_a_manifest_of_a_spreadsheet_is_read(tmp_path):
    text = f"\ufeff{HEAD}a.wav,speech,stop,anna,0.5,CC0,x,train\n,,,,,,,\n"
    (tmp_path / "manifest.csv").write_text(text, encoding="utf-8")
    row = ManifestRow(tmp_path / "a.wav", "speech", "stop", "anna", 0.5, "x", "train")
    assert read_manifest(tmp_path) == [row]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (HEAD.replace("seconds", "length"), "no column 'seconds'; columns are: path, kind, "),
        (f"{HEAD}a.wav,speech,stop,anna,,CC0,x,train\n", "row 2: seconds '', allowed: a number"),
        (f"{HEAD}a.wav,speech,stop,anna,1 s,CC0,x,train\n", "row 2: seconds '1 s', allowed"),
        (f"{HEAD}\n,speech,stop,anna,1,CC0,x,train\n", "row 3: path '', allowed: a file in its"),
    ],
)
def test_a_manifest_that_cannot_be_used_names_row_and_value(tmp_path, text, said):
    (tmp_path / "manifest.csv").write_text(text, encoding="utf-8")
    with pytest.raises(ManifestError) as refused:
        read_manifest(tmp_path)
    assert str(refused.value).startswith(str(tmp_path / "manifest.csv"))
    assert said in str(refused.value)
