# SPDX-License-Identifier: BSD-3-Clause
"""Message classes straight from the .msg files, without roscore or build; tests use them, too."""

from __future__ import annotations

import re
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any

from genpy.dynamic import generate_dynamic

from session_log.types import MessageSource

ROOT = Path(__file__).resolve().parents[1]
SEPARATOR = "\n" + "=" * 80 + "\nMSG: "
BUILT_IN = {"bool", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64"}
BUILT_IN |= {"float32", "float64", "string", "time", "duration", "byte", "char"}


def definition_of(datatype: str) -> str:
    """Full ros1msg text: the type's own definition, then each nested one."""
    text, seen, waiting = _own_text(datatype), {datatype}, _nested(datatype)
    while waiting:
        inner = waiting.pop(0)
        if inner not in seen:
            seen.add(inner)
            text += SEPARATOR + inner + "\n" + _own_text(inner)
            waiting += _nested(inner)
    return text


@cache
def class_of(datatype: str) -> Any:
    """A class that serialises the type."""
    return generate_dynamic(datatype, definition_of(datatype))[datatype]


def source_of(
    topic: str, datatype: str, publisher: str = "/test", is_latched: bool = False
) -> MessageSource:
    """The source of a topic, as the recorder would describe it."""
    kind = class_of(datatype)
    return MessageSource(
        topic, datatype, kind._md5sum, definition_of(datatype), publisher, is_latched
    )


def serialise(message: Any) -> bytes:
    """A message as ROS sends it."""
    buffer = BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def _own_text(datatype: str) -> str:
    package, name = datatype.split("/")
    for folder in (ROOT / "catkin_ws/src" / package, Path("/usr/share") / package):
        path = folder / "msg" / f"{name}.msg"
        if path.exists():
            return path.read_text(encoding="utf-8")
    raise FileNotFoundError(f"{datatype}: no .msg file")


def _nested(datatype: str) -> list[str]:
    package = datatype.split("/")[0]
    found = []
    for line in _own_text(datatype).splitlines():
        words = line.split("#", 1)[0].split()
        if not words:
            continue
        kind = re.sub(r"\[\d*\]$", "", words[0])
        if kind in BUILT_IN:
            continue
        if kind == "Header":
            kind = "std_msgs/Header"
        found.append(kind if "/" in kind else f"{package}/{kind}")
    return found
