# SPDX-License-Identifier: BSD-3-Clause
"""A table as rows of words, for the page and for LaTeX; and how numbers are written in it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

from session_log.report.bounds import Bounded

NONE = "–"


@dataclass(frozen=True)
class TableLine:
    """One row of a table."""

    cells: tuple[str, ...]
    mark: str
    link: str
    time: float | None
    sound: bytes
    transcript: str
    words: str


@dataclass(frozen=True)
class TextTable:
    """Column titles and rows; `marks` holds a word for rows that stand out."""

    columns: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    marks: tuple[str, ...] = ()
    links: tuple[str, ...] = ()  # address behind the first cell of each row; empty: none
    numbers: tuple[int, ...] = ()  # columns that hold numbers
    is_compact: bool = False  # stays a table on a phone; others become cards there
    times: tuple[float, ...] = ()  # [s] of each row, on the time axis of the page
    sounds: tuple[bytes, ...] = ()  # MP3 of each row; empty: none
    transcripts: tuple[str, ...] = ()  # of each sound
    words: tuple[str, ...] = ()  # what each row is found by, beside its cells
    NONE: ClassVar[str] = NONE  # a cell without a value

    def lines(self) -> Iterator[TableLine]:
        """Each row with what belongs to it."""
        for k, cells in enumerate(self.rows):
            yield TableLine(
                cells,
                mark=self.marks[k] if self.marks else "",
                link=self.links[k] if self.links else "",
                time=self.times[k] if self.times else None,
                sound=self.sounds[k] if self.sounds else b"",
                transcript=self.transcripts[k] if self.transcripts else "",
                words=self.words[k] if self.words else "",
            )


def seconds(value: float) -> str:
    """Write a time in seconds; a dash for none."""
    return f"{value:.2f}\u00a0s" if math.isfinite(value) else NONE


def length(value: float) -> str:
    """Write a small length [m] with three digits, in mm, µm or nm; a dash for none."""
    if not math.isfinite(value):
        return NONE
    if abs(value) >= 1e-3:
        return f"{value * 1e3:.3g}\u00a0mm"
    if abs(value) >= 0.1e-6 or value == 0.0:
        return f"{value * 1e6:.3g}\u00a0µm"
    return f"{value * 1e9:.3g}\u00a0nm" if abs(value) >= 1e-12 else "below 0.001\u00a0nm"


def newtons(value: float) -> str:
    """Write a force; a dash for none."""
    return f"{value:.2f}\u00a0N" if math.isfinite(value) else NONE


def bounded(value: Bounded) -> str:
    """Write an estimate with its interval, if both ends of that are known; a dash for none."""
    if not math.isfinite(value.value):
        return NONE
    words = f"{value.value:.2f}"
    if not (math.isfinite(value.low) and math.isfinite(value.high)):
        return words
    return f"{words} ({value.low:.2f} to {value.high:.2f})"


def percent(value: float) -> str:
    """Write a share of one in percent; a dash for none."""
    return f"{value * 100:.1f}\u00a0%" if math.isfinite(value) else NONE


def size_words(size: float) -> str:
    """Write a size in bytes, kB, MB or GB."""
    for unit in ("B", "kB", "MB"):
        if size < 1000:
            return f"{size:.0f} {unit}" if unit == "B" else f"{size:.1f} {unit}"
        size /= 1000
    return f"{size:.2f} GB"


def duration_words(time: float) -> str:
    """Write how long something took in seconds, minutes or hours."""
    if time < 120.0:
        return f"{time:.1f}\u00a0s"
    return f"{time / 60:.1f}\u00a0min" if time < 7200.0 else f"{time / 3600:.1f}\u00a0h"
