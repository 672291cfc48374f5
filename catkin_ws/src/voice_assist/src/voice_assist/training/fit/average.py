# SPDX-License-Identifier: BSD-3-Clause
"""Average the weights of checkpoints.

`python -m voice_assist.training.fit.average a.pt b.pt --out c.pt` writes the mean.

Points of one run, or of runs that began at the same one, lie in one valley of the loss; their mean
is often better than each (Izmailov et al. 2018, arXiv 1803.05407; Wortsman et al. 2022, arXiv
2203.05482), and costs nothing when it is used.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import torch

from typed_config import check_writable, run_command
from voice_assist.errors import ModelError, VoiceError
from voice_assist.recognizer.checkpoint import find_checkpoint, read_checkpoint
from voice_assist.recognizer.embedded import restore
from voice_assist.recognizer.hybrid import WhisperCtc
from voice_assist.training.fit.export import export


def average(models: Sequence[WhisperCtc]) -> WhisperCtc:
    """Mean of the weights, each model counting as much.

    Args:
        models: At least one, all of one shape; the first is changed and given back.

    Raises:
        ModelError: No model, or models of different shapes.
    """
    if not models:
        raise ModelError("no checkpoint to average; give at least one")
    for model in models[1:]:
        if model.dims != models[0].dims:
            raise ModelError(f"checkpoints of different shapes: {models[0].dims}, {model.dims}")
    states = [model.state_dict() for model in models]
    mean = {name: torch.stack([s[name] for s in states]).mean(dim=0) for name in states[0]}
    models[0].load_state_dict(mean)
    return models[0]


def main() -> None:
    """Run the command line; ends with 2 where what was asked cannot be done."""
    if status := run_command(_run, "average", (VoiceError,), failed=2):
        sys.exit(status)


def _run() -> None:
    """Write the mean of the files."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("checkpoints", nargs="+", help="files as `make train` writes them")
    parser.add_argument("--out", type=Path, required=True, help="file to write")
    options = parser.parse_args()
    check_writable(options.out)
    models = [restore(read_checkpoint(find_checkpoint(name))) for name in options.checkpoints]
    export(average(models), options.out)
    print(f"mean of {len(models)} checkpoints: {options.out}")


if __name__ == "__main__":
    main()
