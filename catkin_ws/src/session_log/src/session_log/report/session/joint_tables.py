# SPDX-License-Identifier: BSD-3-Clause
"""Joint positions of messages that may name different joints: the table that says most."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from session_log.report.session.session_data import SampledTable, Track


def by_names(
    names: NDArray[Any], position: NDArray[Any]
) -> Iterator[tuple[tuple[str, ...], list[int], NDArray[np.float64]]]:
    """Messages by their list of names; those whose positions do not fit it are left out.

    Args:
        names: Of the joints, a tuple of each message. Shape (n,).
        position: [rad]; of objects where the messages differ in length. Shape (n,) or (n, k).

    Yields:
        The names, the places of their messages, and the positions of these, shape (m, k).
    """
    fits = [n if len(n) == len(q) else () for n, q in zip(names, position, strict=True)]
    for columns in dict.fromkeys(filter(None, fits)):
        mine = [k for k, found in enumerate(fits) if found == columns]
        rows = position[mine]
        yield columns, mine, rows if rows.ndim == 2 else np.array(list(rows))


class JointTables:
    """A table for each list of names."""

    def __init__(self) -> None:
        self._tables: dict[tuple[str, ...], SampledTable] = {}
        self._seen = 0

    def add(self, time: Track, names: NDArray[Any], position: NDArray[Any]) -> None:
        """Take messages.

        Args:
            time: Of each [s]. Shape (n,).
            names: Of the joints, a tuple of each message. Shape (n,).
            position: [rad]; of objects where the messages differ in length. Shape (n,) or (n, k).
        """
        self._seen += len(time)
        for columns, mine, rows in by_names(names, position):
            table = self._tables.setdefault(columns, SampledTable(("time", *columns)))
            table.extend(time[mine], rows)

    def best(self, urdf: str) -> tuple[SampledTable | None, int]:
        """The table with most joints of a robot model, then with most rows; and what it lacks.

        Args:
            urdf: Text of the model; empty: none.

        Returns:
            The table, None if there is none, and how many messages are not in it.
        """
        known = _joints_of(urdf)
        tables = self._tables.values()
        best = max(tables, key=lambda t: (len(known & set(t.columns)), len(t)), default=None)
        return best, self._seen - len(best) if best else 0


def _joints_of(urdf: str) -> set[str]:
    """Names of the joints of a model; none if it cannot be read."""
    try:
        joints = ElementTree.fromstring(urdf).iter("joint")
    except ElementTree.ParseError:
        return set()
    return {joint.get("name", "") for joint in joints}
