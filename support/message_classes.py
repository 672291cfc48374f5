# SPDX-License-Identifier: BSD-3-Clause
"""Message classes straight from the .msg files, without roscore or build; tests use them, too."""

from __future__ import annotations

from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any

from genmsg.msgs import BUILTIN_TYPES, bare_msg_type, resolve_type
from genpy.dynamic import generate_dynamic

from session_log.types import MessageSource

ROOT = Path(__file__).resolve().parents[1]
SEPARATOR = "\n" + "=" * 80 + "\nMSG: "


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
    folders = (ROOT / "catkin_ws/src", Path("/usr/share"))
    for folder in folders:
        path = folder / package / "msg" / f"{name}.msg"
        if path.exists():
            return path.read_text(encoding="utf-8")
    raise FileNotFoundError(f"{package}/msg/{name}.msg, neither in {folders[0]} nor {folders[1]}")


def _nested(datatype: str) -> list[str]:
    package = datatype.split("/")[0]
    lines = (line.split("#", 1)[0].split() for line in _own_text(datatype).splitlines())
    kinds = (resolve_type(bare_msg_type(words[0]), package) for words in lines if words)
    return [kind for kind in kinds if kind not in BUILTIN_TYPES]
