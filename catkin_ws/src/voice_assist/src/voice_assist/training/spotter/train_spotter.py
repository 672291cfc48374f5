# SPDX-License-Identifier: BSD-3-Clause
"""Train the spotter's head: python -m voice_assist.training.spotter.train_spotter."""

from __future__ import annotations

import argparse
import logging
import math
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.random import Generator
from numpy.typing import NDArray
from torch import Tensor
from torch.nn.functional import softplus

from typed_config import check_writable, count_option, number_option, run_command
from voice_assist.errors import VoiceError
from voice_assist.recognizer.safe_weights import write_weights
from voice_assist.spotter.features import Embedder
from voice_assist.spotter.head import CONTEXT, PATH, Head, Member
from voice_assist.training.fit.train_recognizer import REPOSITORY
from voice_assist.training.options import speech_option
from voice_assist.training.spotter.dataset import LOG, NEGATIVE, SpotterAmounts, Steps, load_steps

_WINDOWS = 4  # steps from the end of a word on in which it shall be found, 0.32 s
_WORDS, _NEGATIVES = 128, 1024  # of a batch
_MINE_EVERY = 300  # steps
_HARD = 0.5  # of the negatives of a batch come from the hardest
_HARDEST = 12_000  # kept at each mining
_SHARES = {"human": 0.6, "synthetic": 0.4}  # of the words of a batch


@dataclass(frozen=True, eq=False)
class EmbeddingTable:
    """All steps in one tensor, with padding before each stream so that every window is whole."""

    embeddings: Tensor  # (rows, WIDTH), scaled, float32
    words: dict[str, NDArray[np.int64]]  # kind: row of each word's first window
    negatives: NDArray[np.int64]  # rows

    def windows(self, rows: NDArray[np.int64]) -> Tensor:
        """What the head sees at rows; from any shape to (*shape, CONTEXT, WIDTH)."""
        index = torch.from_numpy(rows[..., None] + np.arange(1 - CONTEXT, 1))
        return self.embeddings[index]


def make_table(kinds: Mapping[str, Steps], head: Head, quiet: Tensor) -> EmbeddingTable:
    """Join all kinds; sets the head's scaling to that of the data."""
    stacked = np.concatenate([steps.embeddings for steps in kinds.values()]).astype(np.float32)
    head.mean.copy_(torch.from_numpy(stacked.mean(0)))
    head.spread.copy_(torch.from_numpy(stacked.std(0)))
    padding = quiet.expand(CONTEXT, -1)
    parts: list[Tensor] = []
    words: dict[str, NDArray[np.int64]] = {}
    negatives: list[NDArray[np.int64]] = []
    at = 0
    for kind, steps in kinds.items():
        ends = [*steps.begins[1:], len(steps.labels)]
        firsts: list[NDArray[np.int64]] = []
        for begin, end in zip(steps.begins, ends, strict=True):
            parts += [padding, torch.from_numpy(steps.embeddings[begin:end].astype(np.float32))]
            at += CONTEXT
            labels = steps.labels[begin:end]
            firsts.append(at + _firsts(labels))
            negatives.append(at + np.flatnonzero(labels == NEGATIVE))
            at += len(labels)
        words[kind] = np.concatenate(firsts)
    scaled = head.scaled(torch.cat(parts))
    return EmbeddingTable(scaled, words, np.concatenate(negatives))


def train_member(table: EmbeddingTable, steps: int, rate: float, seed: int) -> Member:
    """Train one member from a seed."""
    torch.manual_seed(seed)
    rng = np.random.default_rng(seed)
    member = Member()
    optimiser = torch.optim.AdamW(member.parameters(), lr=rate, weight_decay=0.05)
    hardest = table.negatives
    for step in range(steps):
        if step and step % _MINE_EVERY == 0:
            hardest = _mine(member, table)
        for group in optimiser.param_groups:
            group["lr"] = rate * min(1.0, step / 50) * 0.5 * (1 + math.cos(math.pi * step / steps))
        loss = _loss(member, table, hardest, rng)
        optimiser.zero_grad(set_to_none=True)
        loss.backward()
        optimiser.step()
        if step % 250 == 0:
            LOG.info("step %d: %.4f", step, loss.item())
    return member.eval()


def _loss(
    member: Member, table: EmbeddingTable, hardest: NDArray[np.int64], rng: Generator
) -> Tensor:
    counts = {kind: round(share * _WORDS) for kind, share in _SHARES.items()}
    firsts = np.concatenate(
        [rng.choice(table.words[kind], count) for kind, count in counts.items()]
    )
    rows = firsts[:, None] + np.arange(-1, _WINDOWS)  # one more, for the mean of two windows
    hard = rng.choice(hardest, round(_HARD * _NEGATIVES))
    negatives = np.concatenate([hard, rng.choice(table.negatives, _NEGATIVES - len(hard))])
    seen = torch.cat([table.windows(rows).flatten(0, 1), table.windows(negatives)])
    odds = member(seen)
    said = odds[: rows.size].reshape(rows.shape)
    smooth = (said[:, 1:] + said[:, :-1]) / 2
    best = torch.logsumexp(2 * smooth, 1) / 2 - math.log(_WINDOWS) / 2
    return softplus(-best).mean() + 2 * softplus(odds[rows.size :]).mean()


def _mine(member: Member, table: EmbeddingTable) -> NDArray[np.int64]:
    """The negatives that are taken for the word most."""
    member.eval()
    with torch.inference_mode():
        found = [
            member(table.windows(rows))
            for rows in np.array_split(table.negatives, len(table.negatives) // 8192 + 1)
        ]
    member.train()
    odds = torch.cat(found)
    hardest = odds.topk(min(_HARDEST, len(odds)))
    LOG.info("hardest negatives from %.1f to %.1f", hardest.values[-1], hardest.values[0])
    return np.asarray(table.negatives[hardest.indices.numpy()])


def _firsts(labels: NDArray[np.int32]) -> NDArray[np.int64]:
    """Index of the first window of each word."""
    numbers, firsts = np.unique(labels, return_index=True)
    found = firsts[numbers >= 0].astype(np.int64)
    return found[found + _WINDOWS <= len(labels)]


def parse(arguments: list[str] | None = None) -> argparse.Namespace:
    """Options of a run; the shipped file is older, and had fewer prompts (SPOTTER.md)."""
    parser = argparse.ArgumentParser(description=__doc__)
    add = parser.add_argument
    add("--speech", type=speech_option, default=REPOSITORY.parent / "shared" / "speech")
    add("--cache", type=Path, default=REPOSITORY / ".cache" / "spotter")
    add("--out", type=Path, default=PATH)
    add("--seed", type=int, default=1)
    add("--steps", type=count_option, default=1000, help="of each member")
    add("--rate", type=number_option(0.0), default=2e-3, help="peak learning rate")
    add("--threads", type=count_option, default=1)
    return parser.parse_args(arguments)


def main() -> None:
    """Run the command line; ends with 2 where what was asked cannot be done."""
    if status := run_command(lambda: _run(parse()), "train_spotter", (VoiceError,), failed=2):
        sys.exit(status)


def _run(options: argparse.Namespace) -> None:
    """Embed the material, train the members, write the file."""
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(message)s")
    check_writable(options.out)
    torch.set_num_threads(options.threads)
    began, amounts = time.monotonic(), SpotterAmounts()
    kinds = load_steps(options.speech, options.cache, options.seed, amounts)
    head = Head()
    table = make_table(kinds, head, torch.from_numpy(Embedder().quiet))
    LOG.info(
        "%s words, %d other steps",
        {k: len(v) for k, v in table.words.items()},
        len(table.negatives),
    )
    for number in range(len(head.members)):
        head.members[number] = train_member(
            table, options.steps, options.rate, options.seed * 100 + number
        )
    write_weights(head.state_dict(), options.out)
    LOG.info("%.0f s in all; %s", time.monotonic() - began, options.out)


if __name__ == "__main__":
    main()
