# SPDX-License-Identifier: BSD-3-Clause
"""Typed columns of a message by its definition, and the values of one message for them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import pyarrow as pa
from genpy.dynamic import generate_dynamic

from session_log.mcap_file.decoder import parts_of, present_definition
from session_log.types import MessageSource

TIME: Mapping[str, str] = {"unit": "ns since 1970-01-01T00:00:00Z"}
DURATION: Mapping[str, str] = {"unit": "ns"}
PRIMITIVES: Mapping[str, pa.DataType] = {
    "bool": pa.bool_(),
    "int8": pa.int8(),
    "byte": pa.int8(),
    "uint8": pa.uint8(),
    "char": pa.uint8(),
    "int16": pa.int16(),
    "uint16": pa.uint16(),
    "int32": pa.int32(),
    "uint32": pa.uint32(),
    "int64": pa.int64(),
    "uint64": pa.uint64(),
    "float32": pa.float32(),
    "float64": pa.float64(),
    "string": pa.string(),
    "time": pa.int64(),
    "duration": pa.int64(),
}
LOG_TIME = pa.field("log_time", pa.int64(), False, {**TIME, "meaning": "when it was received"})
_ARRAY = re.compile(r"(.+)\[\d*\]$")
_COMMENTED = re.compile(r"^[ \t]*[\w/\[\]]+[ \t]+(\w+)[ \t]*#(.+)$", re.MULTILINE)
_OCTETS = ("uint8", "char")


class Columns:
    """The flat columns of one type of message: nested fields by dotted names, arrays as lists."""

    def __init__(self, source: MessageSource) -> None:
        """Learn them from the recorded definition.

        Raises:
            ValueError: The definition is damaged.
        """
        definition = present_definition(source.datatype, source.definition)
        try:
            self._classes = generate_dynamic(source.datatype, definition)
        except Exception as error:  # genmsg raises whatever the damage leads to
            raise ValueError(f"definition of {source.datatype}: {error}") from error
        self._root = self._classes[source.datatype]
        self._comments = _comments(source.datatype, definition)
        self._converters: dict[str, Callable[[Any], Any]] = {}
        about = {
            "topic": source.topic,
            "type": source.datatype,
            "md5sum": source.md5sum,
            "definition": source.definition,
        }
        self.schema = pa.schema([LOG_TIME, *self._fields(self._root, "")], about)

    def row(self, log_time: int, content: Any) -> dict[str, Any]:
        """One message, received at a time [ns since 1970]."""
        values = {"log_time": log_time}
        values.update(self._values(content, self._root, ""))
        return values

    def _fields(self, kind: Any, prefix: str) -> Iterator[pa.Field]:
        for name, type_name in _slots(kind):
            if type_name in self._classes:
                yield from self._fields(self._classes[type_name], f"{prefix}{name}.")
            else:
                yield pa.field(
                    prefix + name, self._type(type_name), True, self._about(kind, name, type_name)
                )

    def _about(self, kind: Any, name: str, type_name: str) -> dict[str, str]:
        """Unit of a time, and what the definition says about a field, its unit included."""
        base = type_name.split("[", 1)[0]
        about = {"time": TIME, "duration": DURATION}.get(base, {})
        comment = self._comments.get((kind._type, name), "")
        return {**about, "comment": comment} if comment else dict(about)

    def _type(self, name: str) -> pa.DataType:
        if array := _ARRAY.match(name):
            inner = array[1]
            return pa.binary() if inner in _OCTETS else pa.list_(self._type(inner))
        if name in self._classes:
            slots = _slots(self._classes[name])
            return pa.struct([pa.field(slot, self._type(inner)) for slot, inner in slots])
        return PRIMITIVES[name]

    def _values(self, content: Any, kind: Any, prefix: str) -> Iterator[tuple[str, Any]]:
        for name, type_name in _slots(kind):
            value = getattr(content, name)
            if type_name in self._classes:
                yield from self._values(value, self._classes[type_name], f"{prefix}{name}.")
            else:
                yield prefix + name, self._plain(type_name)(value)

    def _plain(self, name: str) -> Callable[[Any], Any]:
        """Turns a field of a type into what pyarrow takes."""
        if name not in self._converters:
            self._converters[name] = self._converter(name)
        return self._converters[name]

    def _converter(self, name: str) -> Callable[[Any], Any]:
        if array := _ARRAY.match(name):
            if array[1] in _OCTETS:
                return bytes
            inner = self._plain(array[1])
            is_plain = array[1] in PRIMITIVES and inner is _as_it_is
            return list if is_plain else lambda entries: [inner(entry) for entry in entries]
        if name in self._classes:
            return lambda value: self._struct(name, value)
        if name in ("time", "duration"):
            return lambda value: value.to_nsec()
        if name == "byte":
            return _byte
        return bool if name == "bool" else _as_it_is

    def _struct(self, name: str, value: Any) -> dict[str, Any]:
        slots = _slots(self._classes[name])
        return {slot: self._plain(inner)(getattr(value, slot)) for slot, inner in slots}


def _slots(kind: Any) -> list[tuple[str, str]]:
    """Names and types of a message's own fields."""
    return list(zip(kind.__slots__, kind._slot_types, strict=True))


def _comments(datatype: str, definition: str) -> dict[tuple[str, str], str]:
    """Comments behind the fields of a definition, by type and field."""
    found = {}
    for kind, lines in parts_of(datatype, definition).items():
        for field in _COMMENTED.finditer(lines):
            found[kind, field[1]] = field[2].strip()
    return found


def _as_it_is(value: Any) -> Any:
    return value


def _byte(value: Any) -> int:
    """A `byte` is decoded as a number or as one byte, as the version of genpy has it."""
    return int.from_bytes(value, "little", signed=True) if isinstance(value, bytes) else int(value)
