# SPDX-License-Identifier: BSD-3-Clause
"""Batches of similar length, drawn, augmented and turned into tensors ahead."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import torch
from numpy.random import Generator
from torch import Tensor

from voice_assist.recognizer.mel import SAMPLES_PER_STATE, log_mel
from voice_assist.recognizer.vocabulary import (
    END,
    NO_SPEECH,
    NO_TIMESTAMPS,
    START,
    encode,
)
from voice_assist.training.ahead import ahead
from voice_assist.training.data import augment
from voice_assist.training.data.augment import Strength
from voice_assist.training.data.mixture import Item, Mixture
from voice_assist.training.data.noise import Surroundings
from voice_assist.types import RATE

LONGEST_INPUT = 512 * SAMPLES_PER_STATE  # samples; the encoder has 512 positions of 20 ms
POOL = 480  # items drawn together and sorted by length
GRID = 5120  # samples of which lengths are multiples; 16 encoder states
IGNORED = -100  # target of padding


@dataclass(frozen=True, eq=False)
class Batch:
    """Tensors of one optimiser step."""

    mel: Tensor  # (batch, 80, frames), float32
    tokens: Tensor  # (batch, length), compact ids fed to the decoder
    targets: Tensor  # (batch, length), compact ids wanted, IGNORED for padding
    texts: list[list[int]]  # characters of each item, for CTC

    def to(self, device: str) -> Batch:
        """The same with its tensors on a device."""
        return Batch(
            self.mel.to(device), self.tokens.to(device), self.targets.to(device), self.texts
        )


@dataclass(frozen=True, eq=False)
class Drawn:
    """An item with its own speed and surrounding quiet."""

    item: Item
    speed: float
    lead: int  # samples of quiet before
    length: int  # samples in all


class Batches:
    """Endless batches; those of a pool depend on the seed and its index alone."""

    def __init__(
        self,
        mixture: Mixture,
        around: Surroundings,
        how: Strength,
        seed: int,
        seconds: float = 110.0,
        workers: int = 1,
    ) -> None:
        """Set what to draw from.

        Args:
            mixture: Items.
            around: Noise and rooms.
            how: Augmentation.
            seed: Of all chance.
            seconds: Sound per batch, padding included [s].
            workers: Processes that make batches.
        """
        self._mixture, self._around, self._how = mixture, around, how
        self._seed, self._samples, self._workers = seed, int(seconds * RATE), workers

    def pools(self, first: int, done: int = 0) -> Iterator[tuple[int, Batch]]:
        """Pool index and batch, from the first pool on, without its batches that are done."""
        for pool, batches in enumerate(ahead(self._pool, first, self._workers), first):
            for batch in batches[done if pool == first else 0 :]:
                yield pool, batch

    def _pool(self, pool: int) -> list[Batch]:
        rng = np.random.default_rng((self._seed, pool))
        drawn = sorted((self._draw(rng) for _ in range(POOL)), key=lambda one: one.length)
        groups = self._split(drawn[::-1], rng)
        order = rng.permutation(len(groups))
        return [self._make(groups[index], int(rng.integers(2**31))) for index in order]

    def _draw(self, rng: Generator) -> Drawn:
        while True:  # a span whose word times went astray can be longer than the encoder
            drawn = self._draw_any(rng)
            if drawn.length <= LONGEST_INPUT:
                return drawn

    def _draw_any(self, rng: Generator) -> Drawn:
        item = self._mixture.draw(rng)
        speed = float(rng.uniform(*self._how.speed))
        before, after = (int(t * RATE) for t in rng.uniform(*self._how.lead, 2))
        said = int(len(item.samples) / speed) or int(rng.uniform(0.2, 3.0) * RATE)
        return Drawn(item, speed, before, said + before + after)

    def _split(self, drawn: list[Drawn], rng: Generator) -> list[list[Drawn]]:
        """Full batches of few different shapes, from the longest items down.

        Each new shape makes the processor's kernels anew, so lengths are rounded
        up; the last batch is filled with items drawn again, or left out if it is
        less than half full.
        """
        groups, start = [], 0
        while start < len(drawn):
            size = _rounded(drawn[start].length)
            room = max(self._samples // size // 4 * 4, 2)
            group = drawn[start : start + room]
            again = rng.integers(start, len(drawn), room - len(group))
            if 2 * len(group) >= room:
                groups.append(group + [drawn[index] for index in again])
            start += room
        return groups

    def _make(self, drawn: list[Drawn], seed: int) -> Batch:
        rng = np.random.default_rng(seed)
        length = _rounded(drawn[0].length)
        sound = np.stack([_placed(one, length) for one in drawn])
        batch = augment.colour(torch.from_numpy(sound), self._around, self._how, rng)
        batch = augment.add_background(batch, self._around, self._how, rng)
        mel = augment.warp_bands(log_mel(batch), self._how, rng)
        texts = [encode(one.item.text) for one in drawn]
        tokens, targets = teacher_tensors(texts)
        return Batch(augment.mask(mel, rng), tokens, targets, texts)


def teacher_tensors(texts: list[list[int]]) -> tuple[Tensor, Tensor]:
    """Decoder inputs and targets of character ids, padded.

    The target after START is NO_SPEECH where there is no text.
    """
    width = -(-(max(map(len, texts)) + 2) // 8) * 8  # few different shapes
    tokens = torch.full((len(texts), width), END)
    targets = torch.full((len(texts), width), IGNORED)
    for row, text in enumerate(texts):
        line = torch.tensor([START, NO_TIMESTAMPS, *text])
        tokens[row, : len(line)] = line
        wanted = [NO_TIMESTAMPS if text else NO_SPEECH, *text, END]
        targets[row, : len(wanted)] = torch.tensor(wanted)
    return tokens, targets


def _rounded(length: int) -> int:
    return -(-length // GRID) * GRID


def _placed(one: Drawn, length: int) -> np.ndarray:
    if not len(one.item.samples):
        return np.zeros(length, np.float32)
    sound = augment.resample_linear(one.item.samples, one.speed)
    return augment.place(sound, length, one.lead)
