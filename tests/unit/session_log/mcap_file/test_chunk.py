# SPDX-License-Identifier: BSD-3-Clause
import struct

import pytest
from mcap.opcode import Opcode

from session_log.mcap_file.chunk import UNREADABLE, content_of
from session_log.mcap_file.records import McapRecord

SIZES = [2**63, 2**64 - 1]  # [B]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("field", ["uncompressed", "data"])
def test_a_size_that_cannot_be_is_damage(size, field):
    uncompressed, data = (size, 0) if field == "uncompressed" else (0, size)
    body = struct.pack("<QQQII", 0, 0, uncompressed, 0, 0) + struct.pack("<Q", data) + b"x"
    with pytest.raises(UNREADABLE):
        content_of(McapRecord(0, Opcode.CHUNK, body))
