# SPDX-License-Identifier: BSD-3-Clause
"""One topic as a Parquet file, written in row groups, so that memory does not grow with it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pyarrow as pa
from pyarrow.parquet import ParquetWriter

from session_log.export.columns import Columns
from session_log.types import Message

GROUP_ROWS = 8192  # most rows of a group
GROUP_SIZE = 8_000_000  # [B] of message data from which a group is written


class ParquetFile:
    """Typed columns by the recorded definition; times are int64 in ns, arrays are lists."""

    def __init__(self, path: Path, first: Message) -> None:
        """Create the file.

        Args:
            path: Where.
            first: Any message of those to come: all have its type.

        Raises:
            ValueError: The definition is damaged.
        """
        self.path, self.rows = path, 0
        self._columns = Columns(first.source)
        self._writer = ParquetWriter(path, self._columns.schema, compression="zstd")
        self._waiting: list[dict[str, Any]] = []
        self._size = 0  # [B] of the messages that wait

    def add(self, message: Message, content: Any) -> None:
        """Add one message."""
        self._waiting.append(self._columns.row(message.log_time, content))
        self._size += len(message.data)
        self.rows += 1
        if len(self._waiting) >= GROUP_ROWS or self._size >= GROUP_SIZE:
            self._write()

    def _write(self) -> None:
        if self._waiting:
            batch = pa.RecordBatch.from_pylist(self._waiting, schema=self._columns.schema)
            self._writer.write_batch(batch)
            self._waiting, self._size = [], 0

    def __enter__(self) -> ParquetFile:
        return self

    def __exit__(self, *_: object) -> None:
        try:
            self._write()
        finally:
            self._writer.close()
