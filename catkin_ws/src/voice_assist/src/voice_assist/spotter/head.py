# SPDX-License-Identifier: BSD-3-Clause
"""The trained part of the spotter: a committee of small networks over the newest embeddings."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import torch
from torch import Tensor, nn

from typed_config import package_folder
from voice_assist.errors import ModelError
from voice_assist.recognizer.safe_weights import check_weights, read_weights
from voice_assist.spotter.features import WIDTH, Embeddings

PATH = package_folder("voice_assist") / "models" / "spotter.pt"
CONTEXT = 10  # embeddings of one score: with the sound under the first of them 1.5 s
MEMBERS = 3
_NARROW, _HIDDEN = 32, 48


class Member(nn.Module):
    """One opinion: log-odds that the word has just ended."""

    def __init__(self) -> None:
        """Start with random weights."""
        super().__init__()
        self.narrow = nn.Linear(WIDTH, _NARROW)
        self.hidden = nn.Linear(CONTEXT * _NARROW, _HIDDEN)
        self.out = nn.Linear(_HIDDEN, 1)
        self.drop = nn.Dropout(0.3)

    def forward(self, seen: Tensor) -> Tensor:
        """From shape (batch, CONTEXT, WIDTH), scaled, to (batch,)."""
        narrow = self.drop(nn.functional.gelu(self.narrow(seen)).flatten(1))
        hidden = self.drop(nn.functional.gelu(self.hidden(narrow)))
        odds: Tensor = self.out(hidden).squeeze(-1)
        return odds


class Head(nn.Module):
    """Mean opinion of members that started from different seeds."""

    def __init__(self) -> None:
        """Start with random weights and no scaling."""
        super().__init__()
        self.mean: Tensor
        self.spread: Tensor
        self.register_buffer("mean", torch.zeros(WIDTH))
        self.register_buffer("spread", torch.ones(WIDTH))
        self.members = nn.ModuleList(Member() for _ in range(MEMBERS))

    def scaled(self, seen: Tensor) -> Tensor:
        """Embeddings of about unit spread."""
        return (seen - self.mean) / self.spread

    def forward(self, seen: Tensor) -> Tensor:
        """Log-odds [nat] that the word has just ended; from (batch, CONTEXT, WIDTH) to (batch,)."""
        scaled = self.scaled(seen)
        return torch.stack([member(scaled) for member in self.members]).mean(0)


def read_head(path: Path = PATH) -> tuple[Head, str]:
    """Head of a file, by weights only, and the SHA-256 of the file.

    Raises:
        ModelError: The file is missing, damaged, or holds something else, such as NaN.
    """
    head = Head()
    content, digest = read_weights(path)
    shapes = {name: tuple(tensor.shape) for name, tensor in head.state_dict().items()}
    state = check_weights(f"spotter model {path}", content, shapes)
    smallest = float(state["spread"].min())
    if smallest <= 0.0:
        raise ModelError(f"spotter model {path}: spread has {smallest:g}, allowed: above 0")
    head.load_state_dict(state)
    return head.eval(), digest


def scorer(head: Head) -> Callable[[Embeddings], float]:
    """The head for one score: from embeddings of shape (CONTEXT, WIDTH) to log-odds [nat]."""

    def score(seen: Embeddings) -> float:
        with torch.inference_mode():
            return float(head(torch.from_numpy(seen)[None]))

    return score
