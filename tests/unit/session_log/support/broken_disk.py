# SPDX-License-Identifier: BSD-3-Clause
"""A disk that fails while a recording is read from it."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import pytest


class _BrokenFile(io.BytesIO):
    def read(self, size: int | None = -1) -> bytes:
        raise OSError(5, "Input/output error")


def break_reading(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let every further read of a recording fail."""

    def opened(path: Path) -> Any:
        return _BrokenFile(path.read_bytes())

    monkeypatch.setattr("session_log.mcap_file.reader._open", opened)
