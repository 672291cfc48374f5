# SPDX-License-Identifier: BSD-3-Clause
"""Word Error Rate, with the alignment it comes from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

Step = Literal["equal", "substitute", "insert", "delete"]


@dataclass(frozen=True)
class AlignedPair:
    """One step of an alignment."""

    step: Step
    reference: str  # empty where a word was inserted
    heard: str  # empty where a word is missing


def wer(reference: Sequence[str], heard: Sequence[str]) -> float:
    """Substitutions, insertions and deletions per word of the reference.

    Args:
        reference: Words that should have been said.
        heard: Words of the transcript.

    Returns:
        At least 0, and above 1 where much was inserted. Against an empty reference each word heard
        counts as one error, and nothing heard is right: 0.
    """
    return distance(reference, heard) / max(len(reference), 1)


def distance(reference: Sequence[str], heard: Sequence[str]) -> int:
    """Least number of words to substitute, insert or delete (Levenshtein)."""
    return _table(reference, heard)[-1][-1]


def least_distance(reference: Sequence[str], beginning: Sequence[str]) -> int:
    """Least distance of the reference to any text that begins so; each has at least that."""
    return min(row[-1] for row in _table(reference, beginning))


def align(reference: Sequence[str], heard: Sequence[str]) -> tuple[AlignedPair, ...]:
    """One best alignment, first word first; substitutions are preferred."""
    table = _table(reference, heard)
    row, column = len(reference), len(heard)
    pairs: list[AlignedPair] = []
    while row or column:
        cost = table[row][column]
        is_equal = row and column and reference[row - 1] == heard[column - 1]
        if row and column and table[row - 1][column - 1] == cost - (not is_equal):
            row, column = row - 1, column - 1
            step: Step = "equal" if is_equal else "substitute"
            pairs.append(AlignedPair(step, reference[row], heard[column]))
        elif column and table[row][column - 1] == cost - 1:
            column -= 1
            pairs.append(AlignedPair("insert", "", heard[column]))
        else:
            row -= 1
            pairs.append(AlignedPair("delete", reference[row], ""))
    return tuple(reversed(pairs))


def _table(reference: Sequence[str], heard: Sequence[str]) -> list[list[int]]:
    """Distances between all prefixes, (len(reference) + 1, len(heard) + 1)."""
    table = [list(range(len(heard) + 1))]
    for i, expected in enumerate(reference, 1):
        above, row = table[-1], [i]
        for j, word in enumerate(heard, 1):
            row.append(min(above[j] + 1, row[-1] + 1, above[j - 1] + (expected != word)))
        table.append(row)
    return table
