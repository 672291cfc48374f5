# SPDX-License-Identifier: BSD-3-Clause
"""What would end a training run is found before its corpus is made."""

import sys

import pytest
import torch

from tests.unit.voice_assist.support.records import SPEECH_HEAD
from tests.unit.voice_assist.support.small_recognizer import tiny_checkpoint
from voice_assist.errors import ModelError
from voice_assist.training import held_out_figures, phrase_background, speaker_cohort
from voice_assist.training.fit import average, train_recognizer
from voice_assist.training.spotter import dataset, train_overlap, train_spotter, tune
from voice_assist.training.verifier import train_verifier

CORPUS = {
    train_recognizer: "load_corpus",
    train_overlap: "load_overlap_material",
    train_spotter: "load_steps",
    train_verifier: "read_manifest",
}


@pytest.fixture
def refused_first(tmp_path, monkeypatch, refused):
    """What a trainer says of its options; it ends with 2 and without a corpus."""

    def run(module, *words):
        monkeypatch.setattr(module, CORPUS[module], lambda *_: pytest.fail("the corpus was made"))
        return refused(module, "--cache", tmp_path / "cache", *words)

    return run


@pytest.mark.parametrize("module", CORPUS)
def test_a_place_that_cannot_be_written_is_named_first(refused_first, tmp_path, module):
    (tmp_path / "file").write_text("in the way")
    name = module.__name__.rpartition(".")[2]
    said = refused_first(module, "--out", tmp_path / "file" / "z.pt")
    assert said == f"{name}: {tmp_path / 'file'}: Not a directory\n"


@pytest.mark.parametrize("module", [train_recognizer, train_overlap])
def test_a_checkpoint_that_is_not_there_is_named_first(refused_first, tmp_path, module):
    said = refused_first(module, "--from", tmp_path / "none.pt", "--out", tmp_path / "z.pt")
    assert str(tmp_path / "none.pt") in said and said.count("\n") == 1
    assert not (tmp_path / "z.pt").exists()


@pytest.mark.parametrize("module", [*CORPUS, held_out_figures, tune])
def test_a_folder_of_speech_that_has_no_manifest_is_refused(tmp_path, refused, module):
    said = f"--speech: '{tmp_path}', allowed: a folder with manifest.csv\n"
    assert refused(module, "--speech", tmp_path).endswith(said)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--measure-every", 0), "--measure-every: '0', allowed: a whole number from 1"),
        (("--workers", 0), "--workers: '0', allowed: a whole number from 1"),
        (("--device", "nonsense"), "--device: 'nonsense', allowed: cpu"),
        (("--held", 9), "--held 9, allowed: 0 to 5 blocks of the encoder"),
        (("--held", -1), "--held -1, allowed: 0 to 5 blocks"),
        (("--lesson", "twins"), "--lesson twins without --from, allowed: the two together"),
    ],
)
def test_an_option_that_cannot_be_is_named_first(refused_first, tmp_path, words, said):
    assert said in refused_first(train_recognizer, "--out", tmp_path / "z.pt", *words)
    assert not (tmp_path / "cache").exists()


def test_more_blocks_than_the_checkpoint_has_cannot_be_held(monkeypatch, tmp_path):
    monkeypatch.setattr(train_recognizer, "read_checkpoint", lambda _: tiny_checkpoint())
    words = ("--from", "embedded", "--held", "4", "--out", str(tmp_path / "z.pt"))
    with pytest.raises(ModelError, match="--held 4, allowed: 0 to 3 blocks of the encoder"):
        train_recognizer.asked_of_a_run(train_recognizer.parse([*words]))


def test_a_gpu_that_is_not_there_is_named_first(refused_first, monkeypatch):
    def missing(*_, device):
        raise AssertionError(f"Torch not compiled with {device} enabled")

    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    monkeypatch.setattr(torch, "zeros", missing)
    said = "--device: 'cuda', allowed: cpu; torch finds no other here\n"
    assert refused_first(train_overlap, "--device", "cuda").endswith(said)


def test_the_shipped_recogniser_is_not_what_a_run_replaces_unasked(refused_first):
    assert "required: --out" in refused_first(train_recognizer)


@pytest.fixture
def speech(tmp_path):
    """A folder of recordings, none of which is there, by transcript and length."""

    def made(*said):
        rows = [f"{i}.wav,speech,{text},x,{s},CC0,x,train\n" for i, (text, s) in enumerate(said)]
        (tmp_path / "manifest.csv").write_text(SPEECH_HEAD + "".join(rows))
        return tmp_path

    return made


@pytest.mark.parametrize(
    ("said", "held"),
    [
        ((), "0 recordings of 'stop' alone, 0 of one or two other words, 0 of talk over 1.5 s"),
        ((("stop", 0.5), ("up", 0.4)), "1 recordings of 'stop' alone, 1 of one or two"),
        ((("up", 0.4), *[("please stop it now", 3.0)] * 9), "1 of one or two other words, 0 of"),
    ],
)
def test_spotters_without_people_to_learn_from_are_refused_before_anything_is_spoken(
    speech, tmp_path, monkeypatch, refused, said, held
):
    monkeypatch.setattr(dataset, "synthesise", lambda *_: pytest.fail("spoken"))
    monkeypatch.setattr(train_overlap, "read_checkpoint", lambda _: None)
    folder, places = speech(*said), ["--cache", tmp_path, "--out", tmp_path / "z.pt"]
    runs = [(train_overlap, "--check"), (train_overlap,), (train_spotter,)]
    for module, *more in runs:
        line = refused(module, "--speech", folder, *places, *more)
        assert f"{folder}, split train: " in line and held in line
        assert "a spotter needs at least 1 of each" in line and line.count("\n") == 1


def test_a_check_ends_where_all_is_there(speech, tmp_path, monkeypatch):
    monkeypatch.setattr(train_overlap, "load_overlap_material", lambda *_: pytest.fail("made"))
    monkeypatch.setattr(train_overlap, "read_checkpoint", lambda _: None)
    talk = [("the patient is stable today", 3.0)] * train_overlap.AMOUNTS.recorded
    folder = speech(("stop", 0.5), ("up", 0.4), *talk)
    places = ["--out", str(tmp_path / "z.pt"), "--speech", str(folder)]
    monkeypatch.setattr(sys, "argv", ["train", "--check", *places])
    train_overlap.main()
    assert not (tmp_path / "z.pt").exists()


def test_thresholds_without_people_are_refused_before_the_recogniser_is_loaded(
    speech, monkeypatch, refused
):
    monkeypatch.setattr(tune, "make_recognizer", lambda _: pytest.fail("loaded"))
    folder = speech(("stop", 0.5))
    (folder / "manifest.csv").write_text(SPEECH_HEAD + "a.wav,speech,stop,x,0.5,CC0,x,dev\n")
    said = "1 recordings of 'stop' in split dev, 0 of other speech in dev and false_accept_dev"
    assert said in refused(tune, "--speech", folder)


@pytest.mark.parametrize(
    ("module", "words", "said"),
    [
        (average, ("none.pt", "--out", "{}/z.pt"), "average: "),
        (held_out_figures, ("--model", "none.pt"), "held_out_figures: "),
        (phrase_background, ("de", "--config", "{}"), "phrase_background: "),
        (speaker_cohort, ("{}/none", "--out", "{}/z.npz"), "speaker_cohort: "),
    ],
)
def test_every_program_says_in_one_line_what_cannot_be_done(tmp_path, refused, module, words, said):
    line = refused(module, *(word.format(tmp_path) for word in words))
    assert line.startswith(said) and line.count("\n") == 1
    assert not list(tmp_path.iterdir())
