# SPDX-License-Identifier: BSD-3-Clause
"""Refuses messages of other encodings than that of ROS 1, which look like damage where decoded."""

from __future__ import annotations

from session_log.errors import SessionLogError
from session_log.types import MESSAGE_ENCODING, SCHEMA_ENCODING, MessageSource


class WrongEncoding(SessionLogError):
    """The messages of a topic are none of ROS 1, so they are neither read nor copied."""

    def __init__(self, source: MessageSource) -> None:
        found = f"{source.message_encoding!r} with schema {source.schema_encoding!r}"
        allowed = f"{MESSAGE_ENCODING!r} with {SCHEMA_ENCODING!r}"
        self.why = f"recorded as {found}, only {allowed} is read and copied"
        super().__init__(f"{source.topic}: {self.why}")
        self.source = source
