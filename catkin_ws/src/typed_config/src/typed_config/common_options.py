# SPDX-License-Identifier: BSD-3-Clause
"""What command lines share: `--version`, `--print-completion bash`, and numbers within bounds."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from typing import Any, Final

from typed_config.resources import package_version

SHELLS: Final = ("bash", "zsh", "tcsh")


class PrintCompletion(argparse.Action):
    """Prints the script by which a shell completes the words of this parser, and ends.

    shtab makes it, which is imported only here.
    """

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        """Print the script for the shell `values`."""
        import shtab

        print(shtab.complete(parser, values))
        parser.exit(0)


def add_common_options(parser: argparse.ArgumentParser, package: str) -> None:
    """Give a command line `--version`, that of its package, and `--print-completion SHELL`."""
    version = f"%(prog)s {package_version(package)}"
    parser.add_argument("--version", action="version", version=version)
    parser.add_argument(
        "--print-completion",
        action=PrintCompletion,
        choices=SHELLS,
        metavar="SHELL",
        help=f"print the completion for a shell ({', '.join(SHELLS)}), to be sourced there",
    )


def number_option(low: float, high: float = math.inf, unit: str = "") -> Callable[[str], float]:
    """Type of an option that is a finite number from `low` to `high`."""
    allowed = f"{low:g} to {high:g} {unit}".rstrip()
    if not math.isfinite(high):
        allowed = f"{low:g} {unit} or more".replace("  ", " ")

    def read(words: str) -> float:
        try:
            value = float(words)
        except ValueError:
            value = math.nan
        if not (low <= value <= high and math.isfinite(value)):
            raise argparse.ArgumentTypeError(f"{words!r}, allowed: {allowed}")
        return value

    return read


def count_option(words: str) -> int:
    """Type of an option that is a whole number from 1."""
    if not (words.isascii() and words.isdigit() and int(words) > 0):
        raise argparse.ArgumentTypeError(f"{words!r}, allowed: a whole number from 1")
    return int(words)
