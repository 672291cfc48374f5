# SPDX-License-Identifier: BSD-3-Clause
"""Options that every command line has: `--version`, and `--print-completion bash`."""

from __future__ import annotations

import argparse
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
