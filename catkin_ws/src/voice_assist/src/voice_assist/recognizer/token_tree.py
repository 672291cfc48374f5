# SPDX-License-Identifier: BSD-3-Clause
"""Likelihoods of several texts in one sound; what they have in common is read once.

The texts' tokens form a tree. The decoder reads all its nodes in one pass, in which a token sees
only its own ancestors. So a node's place in the sequence does not matter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import torch
from torch import Tensor
from whisper.model import TextDecoder, disable_sdpa


@dataclass
class TokenTree:
    """Tokens, each with the place of the one before it."""

    tokens: list[int] = field(default_factory=list)
    before: list[int] = field(default_factory=list)  # -1: it is the first
    _places: dict[tuple[int, int], int] = field(default_factory=dict)

    def add(self, line: Sequence[int]) -> list[int]:
        """Places of a line's tokens, which begins at the root."""
        path, place = [], -1
        for token in line:
            if (place, token) not in self._places:
                self._places[place, token] = len(self.tokens)
                self.tokens.append(token)
                self.before.append(place)
            place = self._places[place, token]
            path.append(place)
        return path

    def depths(self) -> list[int]:
        """How many tokens stand before each."""
        found: list[int] = []
        for before in self.before:
            found.append(0 if before < 0 else found[before] + 1)
        return found

    def mask(self) -> Tensor:
        """What each token must not see is minus infinity, else 0. Shape (n, n)."""
        seen = torch.eye(len(self.tokens), dtype=torch.bool)
        for place, before in enumerate(self.before):
            if before >= 0:
                seen[place] |= seen[before]
        return torch.zeros(seen.shape).masked_fill(~seen, float("-inf"))


def likelihoods(
    decoder: TextDecoder,
    states: Tensor,
    prompt: Sequence[int],
    lines: Sequence[Sequence[int]],
    end: int,
) -> list[float]:
    """Log-probability [nat] of each line and of the end behind it.

    Args:
        decoder: Of a Whisper model.
        states: Of its encoder. Shape (1, time, d).
        prompt: Tokens in front of every line, at least one.
        lines: Tokens of the texts; may be empty.
        end: Token that ends a text.
    """
    tree = TokenTree()
    paths = [tree.add([*prompt, *line])[len(prompt) - 1 :] for line in lines]
    asked = sorted({place for path in paths for place in path})
    hidden = _read(decoder, states, tree)[:, asked]
    table = decoder.token_embedding.weight.to(hidden.dtype)
    logprobs = (hidden @ table.T)[0].float().log_softmax(-1)
    row = {place: logprobs[i] for i, place in enumerate(asked)}
    return [
        sum(float(row[place][token]) for place, token in zip(path, [*line, end], strict=True))
        for path, line in zip(paths, lines, strict=True)
    ]


def _read(decoder: TextDecoder, states: Tensor, tree: TokenTree) -> Tensor:
    """The decoder's last states of all nodes, shape (1, n, d)."""
    tokens, depths = (
        torch.tensor(one, device=states.device) for one in (tree.tokens, tree.depths())
    )
    x = decoder.token_embedding(tokens) + decoder.positional_embedding[depths]
    x, mask = x[None].to(states.dtype), tree.mask().to(states)
    with disable_sdpa():  # the other way knows no mask but that of a single line
        for block in decoder.blocks:
            x = block(x, states, mask=mask)
    hidden: Tensor = decoder.ln(x)
    return hidden
