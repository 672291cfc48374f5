# SPDX-License-Identifier: BSD-3-Clause
"""Decodes many messages of one topic at once: those of one layout are one NumPy table.

Strings and arrays of variable length move what follows them. Messages in which all of them have
the same lengths have one layout, which holds for almost all messages of a fast topic.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from session_log.mcap_file.decoder import parts_of, present_definition

PRIMITIVES: Mapping[str, str] = {
    **{"bool": "?", "byte": "i1", "char": "u1", "float32": "<f4", "float64": "<f8"},
    **{f"int{8 * n}": f"<i{n}" for n in (1, 2, 4, 8)},
    **{f"uint{8 * n}": f"<u{n}" for n in (1, 2, 4, 8)},
}
STAMP = np.dtype([("secs", "<u4"), ("nsecs", "<u4")])
DURATION = np.dtype([("secs", "<i4"), ("nsecs", "<i4")])
_LENGTH = struct.Struct("<I")
_FIELD = re.compile(r"^[ \t]*([\w/]+)(?:\[(\d*)\])?[ \t]+(\w+)[ \t]*(?:#.*)?$", re.MULTILINE)


@dataclass(frozen=True)
class Field:
    """One field of a definition."""

    kind: str
    count: int  # of an array; 0: as many as the message says; -1: no array
    name: str


@dataclass(frozen=True, eq=False)
class Table:
    """Messages of one layout."""

    index: NDArray[np.intp]  # (n,), places in the batch
    rows: NDArray[Any]  # (n,), structured; fields by dotted names


class Batch:
    """Messages of one topic, by columns.

    Args:
        datatype: Of the messages.
        definition: As it was recorded.
        payloads: Their bytes.
    """

    def __init__(self, datatype: str, definition: str, payloads: Sequence[bytes]) -> None:
        self._walk = layout_of(datatype, definition)
        self._size = len(payloads)
        self.unfit: list[int] = []  # places of messages that do not fit the definition
        self._tables = list(self._sorted(payloads))
        self.fit = np.ones(self._size, bool)  # (n,)
        self.fit[self.unfit] = False

    @property
    def names(self) -> tuple[str, ...]:
        """Fields of the first layout; elements of arrays of strings are numbered."""
        return self._tables[0].rows.dtype.names or () if self._tables else ()

    def column(self, name: str) -> NDArray[Any]:
        """A field of the messages that fit, shape (m,) or, of arrays of one length, (m, k).

        Strings are objects, and so are arrays of several lengths. Times are int64 [ns].

        Raises:
            KeyError: The definition has no such field.
        """
        if any(name not in (table.rows.dtype.names or ()) for table in self._tables):
            raise KeyError(name)
        parts = [(table.index, _plain(table.rows[name])) for table in self._tables]
        shapes = {part.shape[1:] for _, part in parts}
        kind = parts[0][1].dtype if parts and len(shapes) == 1 else np.dtype(object)
        whole = np.empty((self._size, *(shapes.pop() if len(shapes) == 1 else ())), kind)
        for index, part in parts:
            whole[index] = part if whole.ndim == part.ndim else _objects(part)
        return whole[self.fit]

    def lists(self, name: str) -> NDArray[Any]:
        """An array of strings of the messages that fit, shape (m,), each a tuple of any length."""
        whole = np.empty(self._size, object)
        for table in self._tables:
            fields = [f for f in table.rows.dtype.names or () if f.startswith(f"{name}[")]
            columns = [_plain(table.rows[f]) for f in fields]
            for row, place in enumerate(table.index):
                whole[place] = tuple(column[row] for column in columns)
        return whole[self.fit]

    def _sorted(self, payloads: Sequence[bytes]) -> Iterator[Table]:
        by_size: dict[int, list[int]] = {}
        for place, payload in enumerate(payloads):
            by_size.setdefault(len(payload), []).append(place)
        for size, places in by_size.items():
            index = np.array(places)
            raw = np.frombuffer(b"".join(payloads[k] for k in places), np.uint8)
            raw = raw.reshape(len(places), size)
            while len(index):
                try:
                    rows, same = self._walk(raw)
                except (struct.error, ValueError):
                    self.unfit.append(int(index[0]))
                    same = np.arange(len(index)) == 0
                else:
                    yield Table(index[same], rows[same])
                index, raw = index[~same], np.ascontiguousarray(raw[~same])


Walk = Callable[[NDArray[np.uint8]], tuple[NDArray[Any], NDArray[np.bool_]]]


@lru_cache(maxsize=64)
def layout_of(datatype: str, definition: str) -> Walk:
    """Make the function that reads messages of one size by the layout of the first of them.

    Its argument has the shape (n, bytes). It gives a structured array, shape (n,), and which of the
    messages have that layout.
    """
    kinds = _definitions(datatype, present_definition(datatype, definition))

    def walk(raw: NDArray[np.uint8]) -> tuple[NDArray[Any], NDArray[np.bool_]]:
        found = _Layout(kinds, raw[0].tobytes())
        found.message(datatype, "")
        if found.position != raw.shape[1]:
            raise ValueError("the message is longer than its definition")
        same = np.ones(len(raw), bool)
        for place in found.lengths:
            same &= (raw[:, place : place + 4] == raw[0, place : place + 4]).all(axis=1)
        names, formats, offsets = zip(*found.fields, strict=True)
        spec = {"names": names, "formats": formats, "offsets": offsets, "itemsize": raw.shape[1]}
        return raw.view(np.dtype(spec))[:, 0], same  # type: ignore[call-overload]

    return walk


class _Layout:
    """Where the fields of one message lie."""

    def __init__(self, kinds: Mapping[str, list[Field]], data: bytes) -> None:
        self._kinds, self._data = kinds, data
        self.position = 0
        self.fields: list[tuple[str, Any, int]] = []  # name, dtype, place
        self.lengths: list[int] = []  # places of the lengths of strings and arrays

    def message(self, kind: str, prefix: str) -> None:
        if kind not in self._kinds:
            raise ValueError(f"no definition of {kind}")
        for field in self._kinds[kind]:
            self._field(field, prefix + field.name, kind)

    def _field(self, field: Field, name: str, parent: str) -> None:
        count = self._length() if field.count == 0 else field.count
        single = _dtype(field.kind)
        if single is not None:
            self._take(name, single if count < 0 else np.dtype((single, (count,))))
        else:
            for k in range(abs(count)):
                inner = name if count < 0 else f"{name}[{k}]"
                if field.kind == "string":
                    self._take(inner, np.dtype(f"S{self._length()}"))
                else:
                    self.message(_full_name(field.kind, parent, self._kinds), f"{inner}.")

    def _length(self) -> int:
        (length,) = _LENGTH.unpack_from(self._data, self.position)
        if length > len(self._data):
            raise ValueError("a length beyond the message")
        self.lengths.append(self.position)
        self.position += _LENGTH.size
        return int(length)

    def _take(self, name: str, kind: np.dtype[Any]) -> None:
        if self.position + kind.itemsize > len(self._data):
            raise ValueError("the message is shorter than its definition")
        self.fields.append((name, kind, self.position))
        self.position += kind.itemsize


def _definitions(datatype: str, definition: str) -> dict[str, list[Field]]:
    return {
        kind: [
            Field(m[1], -1 if m[2] is None else int(m[2] or 0), m[3]) for m in _FIELD.finditer(text)
        ]
        for kind, text in parts_of(datatype, definition).items()
    }


def _dtype(kind: str) -> np.dtype[Any] | None:
    if kind in ("time", "duration"):
        return STAMP if kind == "time" else DURATION
    return np.dtype(PRIMITIVES[kind]) if kind in PRIMITIVES else None


def _full_name(kind: str, parent: str, kinds: Mapping[str, Any]) -> str:
    if kind == "Header":
        return "std_msgs/Header"
    beside = f"{parent.rsplit('/', 1)[0]}/{kind}"
    return beside if beside in kinds else kind


def _plain(values: NDArray[Any]) -> NDArray[Any]:
    if values.dtype in (STAMP, DURATION):
        return values["secs"].astype(np.int64) * 1_000_000_000 + values["nsecs"]
    if values.dtype.kind == "S":
        known, inverse = np.unique(values, return_inverse=True)
        return np.array([str(v, "utf-8", "replace") for v in known], object)[inverse]
    return values


def _objects(part: NDArray[Any]) -> NDArray[Any]:
    found = np.empty(len(part), object)
    found[:] = list(part)
    return found
