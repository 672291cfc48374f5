# SPDX-License-Identifier: BSD-3-Clause
"""Word Error Rate."""

from __future__ import annotations

from collections.abc import Sequence


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


def min_distance(reference: Sequence[str], beginning: Sequence[str]) -> int:
    """Least distance of the reference to any text that begins so; each has at least that."""
    return min(row[-1] for row in _table(reference, beginning))


def _table(reference: Sequence[str], heard: Sequence[str]) -> list[list[int]]:
    """Distances between all prefixes, (len(reference) + 1, len(heard) + 1)."""
    table = [list(range(len(heard) + 1))]
    for i, expected in enumerate(reference, 1):
        above, row = table[-1], [i]
        for j, word in enumerate(heard, 1):
            row.append(min(above[j] + 1, row[-1] + 1, above[j - 1] + (expected != word)))
        table.append(row)
    return table
