# SPDX-License-Identifier: BSD-3-Clause
"""One topic of a recording as columns in memory, for NumPy and data frames."""

from __future__ import annotations

from typing import Any

import numpy as np
from genpy import Duration
from numpy.typing import NDArray

from session_log.mcap_file.decoder import Decoder, MissingField, fields_of, is_time
from session_log.mcap_file.reader import SessionReader

NANOSECONDS = 1_000_000_000
LOG_TIME = "log_time"  # column: when a message was received


def read_columns(reader: SessionReader, topic: str) -> dict[str, NDArray[Any]]:
    """Read one topic whole; for a long recording `export_topics` writes it without holding it.

    Args:
        reader: The recording.
        topic: Its name, such as /rst_control/state.

    Returns:
        Columns of shape (n,) by dotted names of the fields, `log_time` first. Times are
        datetime64[ns], durations timedelta64[ns]. Numbers and booleans keep their kind, lists and
        texts are objects. Empty if nothing was recorded on the topic.

    Raises:
        Undecodable: A message does not fit its definition.
        MissingField: A message lacks a field of the first one.
    """
    decoder, columns = Decoder(), dict[str, list[Any]]()
    for message in reader.messages({topic}):
        row: dict[str, Any] = {LOG_TIME: np.datetime64(message.log_time, "ns")}
        row.update((name, _plain(value)) for name, value in fields_of(decoder.decode(message)))
        for name in columns or row:
            if name not in row:
                raise MissingField(message.source, name)
            columns.setdefault(name, []).append(row[name])
    return {name: _column(values) for name, values in columns.items()}


def _plain(value: Any) -> Any:
    if not is_time(value):
        return value
    kind = np.timedelta64 if isinstance(value, Duration) else np.datetime64
    return kind(value.secs * NANOSECONDS + value.nsecs, "ns")


def _column(values: list[Any]) -> NDArray[Any]:
    if isinstance(values[0], (bool, int, float, np.datetime64, np.timedelta64)):
        return np.array(values)
    column = np.empty(len(values), object)
    column[:] = values
    return column
