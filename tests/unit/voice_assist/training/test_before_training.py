# SPDX-License-Identifier: BSD-3-Clause
"""What would end a training run is found before its corpus is made."""

import sys

import pytest

from voice_assist.training.fit import train_recognizer
from voice_assist.training.spotter import train_overlap, train_spotter
from voice_assist.training.verifier import train_verifier

CORPUS = {
    train_recognizer: "load_corpus",
    train_overlap: "load_overlap_material",
    train_spotter: "load_steps",
    train_verifier: "read_manifest",
}


@pytest.fixture
def refused(tmp_path, monkeypatch, capsys):
    """What a trainer says of its options; it ends with 2 and without a corpus."""

    def run(module, *words):
        monkeypatch.setattr(module, CORPUS[module], lambda *_: pytest.fail("the corpus was made"))
        cache = ("--cache", str(tmp_path / "cache"))
        monkeypatch.setattr(sys, "argv", ["train", *cache, *map(str, words)])
        with pytest.raises(SystemExit) as ended:
            module.main()
        assert ended.value.code == 2
        return capsys.readouterr().err

    return run


@pytest.mark.parametrize("module", CORPUS)
def test_a_place_that_cannot_be_written_is_named_first(refused, tmp_path, module):
    (tmp_path / "file").write_text("in the way")
    name = module.__name__.rpartition(".")[2]
    said = refused(module, "--out", tmp_path / "file" / "z.pt")
    assert said == f"{name}: {tmp_path / 'file'}: Not a directory\n"


@pytest.mark.parametrize("module", [train_recognizer, train_overlap])
def test_a_checkpoint_that_is_not_there_is_named_first(refused, tmp_path, module):
    said = refused(module, "--from", tmp_path / "none.pt", "--out", tmp_path / "z.pt")
    assert str(tmp_path / "none.pt") in said and said.count("\n") == 1
    assert not (tmp_path / "z.pt").exists()
