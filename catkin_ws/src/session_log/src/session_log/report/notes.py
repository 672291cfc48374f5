# SPDX-License-Identifier: BSD-3-Clause
"""Notes of people on a recording: lines of a text file beside it, of a moment or of all of it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from session_log.errors import OutputFailed

_MOMENT = re.compile(r"(\d+(?:\.\d+)?) s: (.*)")


@dataclass(frozen=True)
class Note:
    """One line."""

    words: str
    time: float | None = None  # [s] since the session began; None: of all of it


def notes_file(recording: Path) -> Path:
    """Where the notes on a recording are, if there are any."""
    return recording.with_suffix(".notes.txt")


def read_notes(recording: Path) -> tuple[Note, ...]:
    """Notes in their order; none where the file cannot be read."""
    try:
        lines = notes_file(recording).read_text("utf-8", errors="replace").splitlines()
    except OSError:
        return ()
    return tuple(_note(line.strip()) for line in lines if line.strip())


def add_note(recording: Path, note: Note) -> Path:
    """Add a line, also behind a last one that an editor left without its end.

    Raises:
        OutputFailed: The file cannot be written.
    """
    target = notes_file(recording)
    moment = "" if note.time is None else f"{note.time:g} s: "
    line = moment + " ".join(note.words.split()) + "\n"
    try:
        with target.open("a+b") as file:  # it is read from anywhere, and written at its end
            file.seek(0)
            old = file.read()
            is_open = bool(old) and not old.endswith(b"\n")
            file.write((b"\n" if is_open else b"") + line.encode())
    except OSError as error:
        raise OutputFailed(target, error) from error
    return target


def _note(line: str) -> Note:
    match = _MOMENT.fullmatch(line)
    return Note(match[2], float(match[1])) if match else Note(line)
