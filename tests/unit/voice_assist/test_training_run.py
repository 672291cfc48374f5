"""A whole run, very short: without recordings, broken off and continued."""

import shutil

import pytest
import whisper

from voice_assist.recognizer import load_recognizer
from voice_assist.training import corpus, fit
from voice_assist.training.synthesis import Amounts, plan_held_out

pytestmark = pytest.mark.skipif(
    any(shutil.which(program) is None for program in ("espeak-ng", "flite", "festival")),
    reason="needs espeak-ng, flite and festival",
)


@pytest.fixture
def tiny_corpus(tmp_path, monkeypatch):
    monkeypatch.setattr(corpus, "plan_held_out", lambda seed: plan_held_out(seed, 1)[:12])
    amounts = Amounts(command=14, variant=3, near=5, talk=2, span=3)
    return corpus.load_corpus(tmp_path / "absent", tmp_path, 1, amounts, 1)


def options(tmp_path, steps):
    arguments = ["--steps", str(steps), "--cache", str(tmp_path), "--out", str(tmp_path / "m.pt")]
    return fit.parse(arguments)


def test_training_without_recordings_leaves_a_checkpoint_and_goes_on(tiny_corpus, tmp_path):
    fit.Run(options(tmp_path, 1), tiny_corpus).train()
    assert whisper.load_model(str(tmp_path / "m.pt"), device="cpu").dims.n_vocab == 51864
    assert load_recognizer(str(tmp_path / "m.pt")).name.endswith("m.pt")
    again = fit.Run(options(tmp_path, 2), tiny_corpus)
    assert again.progress.step == 1
    again.train()
    assert again.progress.step == 2
