# SPDX-License-Identifier: BSD-3-Clause
"""Turns recorded bytes into objects by the definition in the file, without ROS.

A field that had another name when a session was recorded is read under its present name.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from mcap.records import Schema
from mcap_ros1.decoder import DecoderFactory

from session_log.errors import SessionLogError
from session_log.mcap_file.encoding import WrongEncoding
from session_log.types import MESSAGE_ENCODING, SCHEMA_ENCODING, Message, MessageSource

RENAMED_FIELDS: Mapping[str, Mapping[str, str]] = {  # by type of message: former to present name
    "rst_control/ControllerState": {"active": "assistance_enabled"},
    "voice_assist/Utterance": {
        "early": "is_partial",
        "origin": "decided_by",
        "nearest": "nearest_command",
    },
}
_PART = re.compile(r"^(=+\nMSG: (\S+))$", re.MULTILINE)


class Undecodable(SessionLogError):
    """The bytes of a message do not fit its definition."""

    def __init__(self, message: Message, cause: Exception) -> None:
        source = message.source
        super().__init__(f"{source.topic}: not a {source.datatype}: {cause}")
        self.topic = source.topic


class MissingField(SessionLogError):
    """A message was recorded without a field that its reader needs."""

    def __init__(self, source: MessageSource, field: str) -> None:
        super().__init__(f"{source.topic}: {source.datatype} was recorded without {field!r}")
        self.topic = source.topic


class Decoder:
    """Decodes messages; learns each type from the first message of it."""

    def __init__(self) -> None:
        self._factory = DecoderFactory()
        self._known: dict[tuple[str, str], Callable[[bytes], Any]] = {}

    def decode(self, message: Message) -> Any:
        """Return the message as an object with the fields of its definition, as named today.

        Raises:
            Undecodable: Definition or bytes are damaged, or are none of ROS 1.
        """
        if not message.source.is_ros1:
            raise Undecodable(message, ValueError(WrongEncoding(message.source).why))
        key = (message.source.datatype, message.source.definition)
        try:
            if key not in self._known:
                self._known[key] = self._learn(*key)
            return self._known[key](message.data)
        except Exception as error:  # genpy raises whatever the damage leads to
            raise Undecodable(message, error) from error

    def read(self, message: Message, take: Callable[[Any], None]) -> None:
        """Decode a message and let a reader take the fields that it needs.

        Raises:
            Undecodable: Definition or bytes are damaged.
            MissingField: The recorded definition lacks a field of the message.
        """
        content = self.decode(message)
        try:
            take(content)
        except AttributeError as error:
            if error.obj is not content:
                raise
            raise MissingField(message.source, str(error.name)) from error

    def _learn(self, datatype: str, definition: str) -> Callable[[bytes], Any]:
        schema = Schema(
            id=len(self._known) + 1,
            name=datatype,
            encoding=SCHEMA_ENCODING,
            data=present_definition(datatype, definition).encode(),
        )
        decode = self._factory.decoder_for(MESSAGE_ENCODING, schema)
        if decode is None:
            raise ValueError("no definition")
        return decode


def fields_of(content: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield dotted names and values of a decoded message; those of nested ones in their place."""
    for name in content.__slots__:
        value = getattr(content, name)
        if hasattr(value, "__slots__") and not is_time(value):
            yield from fields_of(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def is_time(value: Any) -> bool:
    """Whether a decoded value is a time or a duration."""
    return hasattr(value, "secs") and hasattr(value, "nsecs")


def parts_of(datatype: str, definition: str) -> dict[str, str]:
    """Text of a definition by type: that of the message, then those of the nested ones."""
    first, *rest = _PART.split(definition)
    return {datatype: first, **dict(zip(rest[1::3], rest[2::3], strict=True))}


def present_definition(datatype: str, definition: str) -> str:
    """A recorded definition with the present names of its fields.

    Args:
        datatype: Of the message.
        definition: Full text, nested definitions included.
    """
    first, *rest = _PART.split(definition)  # then of each nested one: its head, type and fields
    parts = [_with_present_names(datatype, first)]
    for head, nested, fields in zip(rest[::3], rest[1::3], rest[2::3], strict=True):
        parts += [head, _with_present_names(nested, fields)]
    return "".join(parts)


def _with_present_names(datatype: str, fields: str) -> str:
    for former, present in RENAMED_FIELDS.get(datatype, {}).items():
        field = re.compile(rf"^([ \t]*[\w/\[\]]+[ \t]+){former}\b", re.MULTILINE)
        fields = field.sub(rf"\g<1>{present}", fields)
    return fields
