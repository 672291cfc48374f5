# SPDX-License-Identifier: BSD-3-Clause
"""Turns recorded bytes into objects by the definition in the file, without ROS."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from mcap.records import Schema
from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap_ros1.decoder import DecoderFactory

from session_log.errors import SessionLogError
from session_log.types import Message


class Undecodable(SessionLogError):
    """The bytes of a message do not fit its definition."""

    def __init__(self, message: Message, cause: Exception) -> None:
        source = message.source
        super().__init__(f"{source.topic}: not a {source.datatype}: {cause}")
        self.topic = source.topic


class Decoder:
    """Decodes messages; learns each type from the first message of it."""

    def __init__(self) -> None:
        self._factory = DecoderFactory()
        self._known: dict[tuple[str, str], Callable[[bytes], Any]] = {}

    def decode(self, message: Message) -> Any:
        """Return the message as an object with the fields of its definition.

        Raises:
            Undecodable: Definition or bytes are damaged.
        """
        key = (message.source.datatype, message.source.definition)
        try:
            if key not in self._known:
                self._known[key] = self._learn(*key)
            return self._known[key](message.data)
        except Exception as error:  # genpy raises whatever the damage leads to
            raise Undecodable(message, error) from error

    def _learn(self, datatype: str, definition: str) -> Callable[[bytes], Any]:
        schema = Schema(
            id=len(self._known) + 1,
            name=datatype,
            encoding=SchemaEncoding.ROS1,
            data=definition.encode(),
        )
        decode = self._factory.decoder_for(MessageEncoding.ROS1, schema)
        if decode is None:
            raise ValueError("no definition")
        return decode
