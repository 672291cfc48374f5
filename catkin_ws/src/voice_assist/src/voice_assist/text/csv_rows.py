# SPDX-License-Identifier: BSD-3-Clause
"""Rows of a CSV file that a person wrote, by the names of its columns."""

from __future__ import annotations

import csv
from pathlib import Path

from voice_assist.errors import ManifestError


def csv_rows(path: Path, *columns: str) -> list[tuple[int, tuple[str, ...]]]:
    """Rows that are not empty.

    Args:
        path: In UTF-8. In the header, capitals and spaces around a name do not count.
        columns: Those to read, in lower case; the file may have others.

    Returns:
        Number of the row's last line in the file, from 1, and its cells in the order of `columns`.
        A cell that is missing is empty.

    Raises:
        ManifestError: The file cannot be read, is no CSV in UTF-8, or lacks a column.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.reader(file)
            header = [name.strip().casefold() for name in next(reader, [])]
            rows = [(reader.line_num, row) for row in reader if any(cell.strip() for cell in row)]
    except OSError as error:
        raise ManifestError(f"{path}: {error.strerror}") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise ManifestError(f"{path}: not a CSV file in UTF-8 ({error})") from error
    if missing := [name for name in columns if name not in header]:
        there = ", ".join(header) or "none"
        raise ManifestError(f"{path}: no column {missing[0]!r}; columns are: {there}")
    places = [header.index(name) for name in columns]
    padding = [""] * len(header)
    return [(line, tuple([*row, *padding][place] for place in places)) for line, row in rows]
