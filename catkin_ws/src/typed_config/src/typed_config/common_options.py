# SPDX-License-Identifier: BSD-3-Clause
"""What command lines share: common options, numbers within bounds, and how they end."""

from __future__ import annotations

import argparse
import errno
import io
import math
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
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


def run_command(
    action: Callable[[], int | None], name: str, refusals: tuple[type[Exception], ...], failed: int
) -> int:
    """Do what a command line asks for, with no traceback for what its user can do about.

    A closed output takes all and keeps nothing. A letter that an output lacks is written by its
    number.

    Args:
        action: Gives the exit status; None: 0. It may end by SystemExit, as argparse does.
        name: Of the command, in front of what is wrong.
        refusals: Kinds of errors that say what is wrong.
        failed: Exit status after one of them, or after an error of the system.

    Returns:
        The exit status; 130 after Ctrl-C.
    """
    _prepare_outputs()
    try:
        try:
            status = action() or 0
        except SystemExit:
            sys.stdout.flush()
            raise
        except refusals as error:
            print(f"{name}: {error}", file=sys.stderr)
            status = failed
        sys.stdout.flush()
    except KeyboardInterrupt:
        return 130
    except OSError as error:
        if not isinstance(error, BrokenPipeError):  # whose reader has gone, as `head` does
            words = f"{error.filename or 'the output'}: {error.strerror or error}"
            print(f"{name}: {words}", file=sys.stderr)
        try:
            sys.stdout.flush()  # what was printed before a file failed
        except OSError:  # Python would try to write once more at its end
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return failed
    return status


def _prepare_outputs() -> None:
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:  # closed by the caller, as `>&-` does
            nowhere = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115 - open to the end
            setattr(sys, name, nowhere)
        elif isinstance(stream, io.TextIOWrapper) and stream.errors == "strict":
            stream.reconfigure(errors="backslashreplace")


def check_writable(path: Path) -> None:
    """Find out before long work whether a file can be written; makes its folder.

    Raises:
        OSError: It cannot.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except FileExistsError as error:
        words = os.strerror(errno.ENOTDIR)
        raise NotADirectoryError(errno.ENOTDIR, words, str(path.parent)) from error
    is_new = not path.exists()
    path.open("a", encoding="utf-8").close()
    if is_new:
        path.unlink()


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


def place_option(reach: float) -> Callable[[str], tuple[float, ...]]:
    """Type of an option that is a place, as `--trocar="0.4 -2e-5 0.4"`, each within `reach` [m]."""
    number = number_option(-reach, reach, "m")

    def read(words: str) -> tuple[float, ...]:
        place = tuple(map(number, words.split()))
        if len(place) != 3:
            raise argparse.ArgumentTypeError(f"{words!r}, allowed: three numbers, x y z")
        return place

    return read


def count_option(words: str) -> int:
    """Type of an option that is a whole number from 1."""
    if not (words.isascii() and words.isdigit() and int(words) > 0):
        raise argparse.ArgumentTypeError(f"{words!r}, allowed: a whole number from 1")
    return int(words)


@contextmanager
def replacing(path: Path, suffix: str) -> Iterator[Path]:
    """A file to write beside another one, whose place it then takes; no error leaves it there.

    Args:
        path: To be replaced; its folder is made where it is missing.
        suffix: Of the file to write.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_suffix(f".{os.getpid()}{suffix}")  # another program may write the same
    try:
        yield temporary
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
