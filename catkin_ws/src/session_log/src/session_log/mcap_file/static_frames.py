# SPDX-License-Identifier: BSD-3-Clause
"""Static transforms of several nodes as one message, for a topic that has one publisher."""

from __future__ import annotations

from io import BytesIO
from typing import Any, Final

from session_log.mcap_file.decoder import Decoder
from session_log.types import Message

STATIC_TOPIC: Final = "/tf_static"


class StaticFrames:
    """Follows the messages of the topic: the last transform of each child frame holds."""

    def __init__(self) -> None:
        self._decoder = Decoder()
        self._known: dict[str, Any] = {}  # by child frame

    def merged(self, message: Message) -> bytes:
        """A message with all transforms so far, those of the messages before it included.

        Raises:
            Undecodable: Definition or bytes are damaged.
            MissingField: It is another type of message.
        """
        buffer = BytesIO()
        self._decoder.read(message, lambda content: self._write(content, buffer))
        return buffer.getvalue()

    def _write(self, content: Any, buffer: BytesIO) -> None:
        self._known |= {frame.child_frame_id: frame for frame in content.transforms}
        content.transforms = list(self._known.values())
        content.serialize(buffer)
