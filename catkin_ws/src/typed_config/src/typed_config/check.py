# SPDX-License-Identifier: BSD-3-Clause
"""Reads the settings files of a launch before roslaunch does, and strictly.

roslaunch takes the last of two equal keys without a word, and a file that was cut off as far as it
goes; the nodes see only what is left. roslaunch runs this while it reads a launch file, and ends
where it ends with an error. With `--launch FILE` the command line of roslaunch is checked too, and
that none of its nodes runs already.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from typed_config.errors import ConfigError
from typed_config.launch_line import caller_words, check_launch_line
from typed_config.ros.running_nodes import running_again
from typed_config.strict_yaml import load_yaml


def main(argv: Sequence[str] | None = None) -> None:
    """Read the files named, print how many, or end with the reason on the error output."""
    parser = argparse.ArgumentParser(prog="check_settings", description=__doc__)
    parser.add_argument("--launch", type=Path, help="the launch file that asks for this")
    parser.add_argument("files", nargs="*", help="settings files, YAML")
    given = parser.parse_args(argv)
    try:
        if given.launch is not None:
            words = caller_words()
            check_launch_line(given.launch, words)
            _check_running(given.launch, words)
        for file in given.files:
            load_yaml(file)
    except ConfigError as error:
        print(f"\nthis launch does not start: {error}\n", file=sys.stderr)
        sys.exit(2)
    print(f"{len(given.files)} files")


def _check_running(file: Path, words: Sequence[str]) -> None:
    if running := running_again(file, words):
        raise ConfigError(
            "running node",
            ", ".join(running),
            "none of this launch; end the other launch first, or set another ROS_NAMESPACE",
        )
