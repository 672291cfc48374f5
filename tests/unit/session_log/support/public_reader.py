# SPDX-License-Identifier: BSD-3-Clause
"""The public stream reader on files that a kill has cut off."""

from mcap.records import Message
from mcap.stream_reader import StreamReader


def streamed(path):
    """Sequences that it gives before it meets the cut; they are unbroken."""
    found = []
    with path.open("rb") as file:
        try:
            for record in StreamReader(file, validate_crcs=True).records:
                if isinstance(record, Message):
                    found.append(record.sequence)
        except Exception as error:  # whatever the public reader makes of a cut
            assert "EndOfFile" in type(error).__name__ or "struct" in str(type(error))
    assert found == list(range(1, len(found) + 1))
    return found
