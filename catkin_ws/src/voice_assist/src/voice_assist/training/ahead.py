# SPDX-License-Identifier: BSD-3-Clause
"""What training needs next, made by other processes while it computes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from sys import maxsize
from typing import Generic, TypeVar

import torch
from torch.utils.data import DataLoader, Dataset

T = TypeVar("T")


class _Made(Dataset[T], Generic[T]):
    def __init__(self, make: Callable[[int], T]) -> None:
        self._make = make

    def __getitem__(self, index: int) -> T:
        return self._make(index)


def ahead(make: Callable[[int], T], first: int, workers: int) -> Iterator[T]:
    """`make(first)`, `make(first + 1)` and so on, in this order for any number of processes.

    Args:
        make: Gives the same for the same number; runs in a forked process with one thread.
        first: Number to begin with.
        workers: Processes, each of which keeps two results ahead.

    Raises:
        ValueError: Fewer than one process.
    """
    if workers < 1:
        raise ValueError(f"{workers} processes to make batches, allowed: at least 1")
    loader = DataLoader(
        _Made(make),
        batch_size=None,
        sampler=range(first, maxsize),
        num_workers=workers,
        multiprocessing_context="fork",
        generator=torch.Generator(),  # else each loader draws from the run's own chance
    )
    return iter(loader)
