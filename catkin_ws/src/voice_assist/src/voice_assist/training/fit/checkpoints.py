# SPDX-License-Identifier: BSD-3-Clause
"""The state of a training run, kept so that it can go on after a break."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import torch
from torch import Tensor

from voice_assist.recognizer.hybrid import WhisperCtc
from voice_assist.recognizer.safe_weights import write_weights

AVERAGE_DECAY = 0.998


@dataclass
class Progress:
    """How far a run has come."""

    step: int = 0
    pool: int = 0  # next pool of batches
    seconds: float = 0.0  # spent training so far
    best: float = -1e9  # best score measured so far


class Average:
    """Exponential moving average of a model's weights, used for measuring."""

    def __init__(self, model: WhisperCtc) -> None:
        """Start from the model's present weights."""
        self.weights = {k: v.detach().clone() for k, v in model.state_dict().items()}

    def update(self, model: WhisperCtc, step: int) -> None:
        """Move towards the model's weights; faster in the first steps."""
        keep = min(AVERAGE_DECAY, (1 + step) / (10 + step))
        held = list(self.weights.values())
        torch._foreach_mul_(held, keep)
        torch._foreach_add_(held, list(model.state_dict().values()), alpha=1 - keep)


def save_progress(
    path: Path,
    model: WhisperCtc,
    optimiser: torch.optim.Optimizer,
    average: Average,
    progress: Progress,
) -> None:
    """Write everything that going on needs; a crash leaves the old file."""
    state = {
        "model": model.state_dict(),
        "optimiser": optimiser.state_dict(),
        "average": average.weights,
        "progress": vars(progress),
    }
    write_weights(state, path)


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
