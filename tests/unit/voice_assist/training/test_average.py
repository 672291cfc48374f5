# SPDX-License-Identifier: BSD-3-Clause
"""The mean of checkpoints."""

import sys
from dataclasses import replace

import pytest
import torch

from tests.unit.voice_assist.support.small_recognizer import SMALL, small_model
from voice_assist.errors import ModelError
from voice_assist.recognizer.checkpoint import read_checkpoint
from voice_assist.recognizer.embedded import restore
from voice_assist.training.fit import average
from voice_assist.training.fit.export import export


def test_every_weight_is_the_mean(tmp_path, monkeypatch):
    paths = [tmp_path / f"{seed}.pt" for seed in range(3)]
    for seed, path in enumerate(paths):
        export(small_model(seed), path)
    out = tmp_path / "mean.pt"
    monkeypatch.setattr(sys, "argv", ["average", *map(str, paths), "--out", str(out)])
    average.main()
    parts = [restore(read_checkpoint(path)).state_dict() for path in paths]
    for name, weight in restore(read_checkpoint(out)).state_dict().items():
        mean = sum(part[name] for part in parts) / 3
        torch.testing.assert_close(weight, mean, atol=2e-3, rtol=2e-3)  # kept in half precision


def test_a_model_averaged_with_itself_is_itself():
    weights = small_model(1).state_dict()
    for name, weight in average.average([small_model(1), small_model(1)]).state_dict().items():
        torch.testing.assert_close(weight, weights[name])


def test_models_of_different_shapes_and_no_model_are_refused():
    with pytest.raises(ModelError, match=r"different shapes.*n_audio_layer=2.*n_audio_layer=1"):
        average.average([small_model(1), small_model(1, replace(SMALL, n_audio_layer=1))])
    with pytest.raises(ModelError, match="at least one"):
        average.average([])
