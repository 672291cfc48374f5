# SPDX-License-Identifier: BSD-3-Clause
"""The state of a training run, kept so that it can go on after a break."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import torch
from torch import Tensor

from voice_assist.errors import ModelError
from voice_assist.recognizer.hybrid import WhisperCtc
from voice_assist.recognizer.safe_weights import write_weights
from voice_assist.training.cache_key import differences

_DECAY = 0.998  # of the running mean of the weights
_ASKED = "asked"


@dataclass
class Progress:
    """How far a run has come."""

    step: int = 0
    pool: int = 0  # of batches, the one at hand or the next
    seconds: float = 0.0  # spent training so far
    best: float = -1e9  # best score measured so far
    best_step: int = 0  # that it was measured at; 0: none yet
    batch: int = 0  # batches of the pool that are done


def kept_share(step: int) -> float:
    """Share of a running mean that a step leaves; less in the first steps."""
    return min(_DECAY, (1 + step) / (10 + step))


class Average:
    """Exponential moving average of a model's weights, used for measuring."""

    def __init__(self, model: WhisperCtc) -> None:
        """Start from the model's present weights."""
        self.weights = {k: v.detach().clone() for k, v in model.state_dict().items()}

    def update(self, model: WhisperCtc, step: int) -> None:
        """Move towards the model's weights; faster in the first steps."""
        keep = kept_share(step)
        held = list(self.weights.values())
        torch._foreach_mul_(held, keep)
        torch._foreach_add_(held, list(model.state_dict().values()), alpha=1 - keep)


def save_progress(
    path: Path,
    model: WhisperCtc,
    optimiser: torch.optim.Optimizer,
    average: Average,
    progress: Progress,
    asked: Mapping[str, object],
) -> None:
    """Write everything that going on needs; a crash leaves the old file.

    Args:
        path: File to write.
        model: As it is now.
        optimiser: Its optimiser.
        average: Its running mean.
        progress: How far it has come.
        asked: Options of the run, by which it is known again.
    """
    state = {
        "model": model.state_dict(),
        "optimiser": optimiser.state_dict(),
        "average": average.weights,
        "progress": vars(progress),
        _ASKED: dict(asked),
    }
    write_weights(state, path)


def check_same_run(path: Path, asked: Mapping[str, object]) -> None:
    """Refuse to go on with what another run left.

    Args:
        path: What save_progress wrote; where it is absent, the run begins.
        asked: Options of the run now.

    Raises:
        ModelError: It was another run; the file stays.
    """
    if not path.exists():
        return
    state = torch.load(path, map_location="cpu", weights_only=True, mmap=True)
    if differs := differences(state.get(_ASKED), asked):
        allowed = "allowed: the same ones, another name for --out, or to remove that folder"
        raise ModelError(f"{path.parent} holds a run with {differs}; {allowed}")


def load_progress(
    path: Path,
    model: WhisperCtc,
    optimiser: torch.optim.Optimizer,
    average: Average,
) -> Progress:
    """Restore a run in place; a fresh Progress where the file is absent."""
    if not path.exists():
        return Progress()
    where = next(model.parameters()).device
    state = torch.load(path, map_location=where, weights_only=True)
    model.load_state_dict(state["model"])
    optimiser.load_state_dict(state["optimiser"])
    weights: dict[str, Tensor] = state["average"]
    average.weights = weights
    return Progress(**state["progress"])
