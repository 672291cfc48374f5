# SPDX-License-Identifier: BSD-3-Clause
"""A whole run, very short: without recordings, broken off and continued."""

import shutil
from dataclasses import replace

import pytest
import torch
import whisper

from tests.unit.voice_assist.support.small_recognizer import SMALL
from voice_assist.recognizer import load_recognizer
from voice_assist.recognizer.checkpoint import EMBEDDED_PATH, read_checkpoint
from voice_assist.training.data import batches, corpus, synthesis
from voice_assist.training.data.synthesis import SynthesisAmounts, cast_voice, plan_held_out
from voice_assist.training.fit import start, train_recognizer

pytestmark = pytest.mark.skipif(
    any(shutil.which(program) is None for program in ("espeak-ng", "flite", "festival")),
    reason="needs espeak-ng, flite and festival",
)


def cast_installed_voice(text, variants, rng):
    """RHVoice, which Debian keeps outside main, is for training in earnest only."""
    while (prompt := cast_voice(text, variants, rng)).engine == "rhvoice":
        pass
    return prompt


@pytest.fixture(scope="module")
def tiny_corpus(tmp_path_factory):
    folder = tmp_path_factory.mktemp("corpus")
    amounts = SynthesisAmounts(command=14, variant=3, near=5, hard=3, talk=2, span=3, short=2)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(corpus, "plan_held_out", lambda seed: plan_held_out(seed, 1)[:12])
        patch.setattr(synthesis, "cast_voice", cast_installed_voice)
        return corpus.load_corpus(folder / "absent", folder, 1, amounts, 1)


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    """Few items, where training in earnest draws hundreds, and a small network to begin with."""
    monkeypatch.setattr(batches, "POOL", 40)
    monkeypatch.setattr(start, "SMALL", replace(SMALL, n_text_ctx=start.SMALL.n_text_ctx))


def options(tmp_path, steps, *more):
    arguments = ["--steps", str(steps), "--cache", str(tmp_path), "--out", str(tmp_path / "m.pt")]
    return train_recognizer.parse([*arguments, "--batch", "0.25", *more])


def test_training_without_recordings_leaves_a_checkpoint_and_goes_on(tiny_corpus, tmp_path):
    train_recognizer.TrainingRun(options(tmp_path, 1), tiny_corpus).train()
    assert whisper.load_model(str(tmp_path / "m.pt"), device="cpu").dims.n_vocab == 51864
    assert load_recognizer(str(tmp_path / "m.pt")).name.endswith("m.pt")
    kept = tmp_path / "run_m" / "step_00001.pt"  # of every measurement, for averaging
    assert kept.read_bytes() == (tmp_path / "m.pt").read_bytes()
    again = train_recognizer.TrainingRun(options(tmp_path, 2), tiny_corpus)
    assert again.progress.step == 1
    again.train()
    assert again.progress.step == 2


def test_a_checkpoint_is_trained_further_in_a_run_of_its_own_but_for_held_blocks(
    tiny_corpus, tmp_path
):
    (tmp_path / "run_first").mkdir()
    (tmp_path / "run_first" / "progress.pt").write_bytes(b"of a run from nothing")
    more = ("--from", "embedded", "--held", "2", "--lesson", "voices")
    run = train_recognizer.TrainingRun(options(tmp_path, 1, *more), tiny_corpus)
    assert run.progress.step == 0
    run.train()
    before, after = (read_checkpoint(path) for path in (EMBEDDED_PATH, tmp_path / "m.pt"))
    first, second = before.ctc["weight"], after.ctc["weight"]
    assert not torch.equal(first, second)
    torch.testing.assert_close(first, second, atol=0.01, rtol=0.01)
    moved = {n for n in before.state if not torch.equal(before.state[n], after.state[n])}
    held = tuple(f"encoder.{part}." for part in ("conv1", "conv2", "blocks.0", "blocks.1"))
    assert not [name for name in moved if name.startswith(held)]
    assert {f"encoder.blocks.{i}.mlp.0.weight" for i in (2, 3)} <= moved
