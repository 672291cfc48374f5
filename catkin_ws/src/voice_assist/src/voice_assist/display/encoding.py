# SPDX-License-Identifier: BSD-3-Clause
"""A snapshot as one server-sent event."""

from __future__ import annotations

import json
import math
from dataclasses import fields, is_dataclass
from typing import Any

from voice_assist.display.snapshot import Snapshot

DIGITS = 6  # behind the point: micrometres


def event(snapshot: Snapshot) -> bytes:
    """The event that all viewers get; JSON has no infinity, so what is no number is null."""
    text = json.dumps(_plain(snapshot), ensure_ascii=True, separators=(",", ":"), allow_nan=False)
    return b"data: " + text.encode("ascii") + b"\n\n"


def _plain(value: Any) -> Any:
    if isinstance(value, float):
        return round(value, DIGITS) if math.isfinite(value) else None
    if is_dataclass(value):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
    return [_plain(entry) for entry in value] if isinstance(value, tuple) else value
