# SPDX-License-Identifier: BSD-3-Clause
"""Reads a recording by the message classes that ROS generated, and writes each message again.

A process of its own, without pytest's paths: those hide the generated packages behind the sources.
"""

import json
import sys
from collections import Counter
from io import BytesIO
from pathlib import Path

from mcap.reader import make_reader
from roslib.message import get_message_class


def main(path):
    """Print how many messages of each type came out byte for byte; fail where one did not."""
    count = Counter()
    with path.open("rb") as stream:
        for schema, channel, message in make_reader(stream, validate_crcs=True).iter_messages():
            kind = get_message_class(schema.name)
            if kind is None or kind._md5sum != channel.metadata["md5sum"]:
                sys.exit(f"{channel.topic}: no class of ROS for {schema.name}, or another version")
            buffer = BytesIO()
            kind().deserialize(message.data).serialize(buffer)
            if buffer.getvalue() != message.data:
                sys.exit(f"{channel.topic}: message {message.sequence} is written otherwise")
            count[schema.name] += 1
    print(json.dumps(count))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
