# SPDX-License-Identifier: BSD-3-Clause
"""Reads the settings files of a launch before roslaunch does, and strictly.

roslaunch takes the last of two equal keys without a word, and a file that was cut off as far as it
goes; the nodes see only what is left. roslaunch runs this while it reads a launch file, and ends
where it ends with an error.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from typed_config.errors import ConfigError
from typed_config.strict_yaml import load_yaml


def main(argv: Sequence[str] | None = None) -> None:
    """Read the files named, print how many, or end with the reason on the error output."""
    files = sys.argv[1:] if argv is None else argv
    try:
        for file in files:
            load_yaml(file)
    except ConfigError as error:
        print(f"\nthis launch does not start: {error}\n", file=sys.stderr)
        sys.exit(2)
    print(f"{len(files)} files")
