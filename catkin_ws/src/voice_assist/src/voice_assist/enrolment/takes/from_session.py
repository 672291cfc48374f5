# SPDX-License-Identifier: BSD-3-Clause
"""Takes from a recorded session, after a person has said what was really said in it.

The recording is read by a function that a setting names, so that neither package knows the other.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from voice_assist.enrolment.takes.script import RecordedTake
from voice_assist.errors import ManifestError, VoiceError
from voice_assist.profile.manifest import COMMAND, TALK
from voice_assist.text.csv_rows import csv_rows
from voice_assist.text.normalize import normalize, with_same_words
from voice_assist.types import RATE, frozen_samples

COLUMNS = ("number", "time", "seconds", "heard", "command", "said")


class SpokenUtterance(Protocol):
    """One recorded utterance."""

    @property
    def time(self) -> float: ...  # noqa: D102 - [s] since the session began
    @property
    def heard(self) -> str: ...  # noqa: D102 - transcript
    @property
    def command(self) -> str: ...  # noqa: D102 - taken; empty: none
    @property
    def samples(self) -> NDArray[np.int16]: ...  # noqa: D102 - (n,), 16 kHz mono


class Uncorrected(VoiceError):
    """Nobody has said yet what was really said."""


def read_takes(
    session: Path, corrections: Path | None, phrases: Sequence[str], reader: str
) -> list[RecordedTake]:
    """Utterances of a recording with what a person wrote for them.

    Args:
        session: An MCAP file, or the folder of a session.
        corrections: CSV, made for filling in where it does not exist; its column `said` is what a
            person wrote, `number`, `time` and `seconds` are as it was made.
        phrases: Of all commands.
        reader: `module:function` that reads recordings.

    Raises:
        Uncorrected: The file was just made; says what to do with it.
        ManifestError: The recording or the file cannot be used, or nothing was said in it.
    """
    utterances = _read(session, reader)
    if not utterances:
        raise ManifestError(f"{session}: no utterance with its sound in it; nothing was written")
    if corrections is None or not corrections.exists():
        path = corrections or Path("corrections.csv")
        _write(path, utterances)
        words = "the column said: a command, talk, or nothing for what shall be left out"
        raise Uncorrected(f"{path} was written; correct {words}; then --corrections {path}")
    return _corrected(session, corrections, utterances, phrases)


def _read(session: Path, reader: str) -> list[SpokenUtterance]:
    module, _, function = reader.partition(":")
    try:
        read: Any = getattr(import_module(module), function)
    except (ImportError, AttributeError, ValueError) as error:
        allowed = "allowed: module:function of an installed package"
        raise ManifestError(f"session_reader {reader!r}: {error}; {allowed}") from error
    try:
        return cast("list[SpokenUtterance]", read(session))
    except Exception as error:  # the reader's own errors are not known here
        raise ManifestError(f"{session}: cannot be read: {error}") from error


def _write(path: Path, utterances: Sequence[SpokenUtterance]) -> None:
    try:
        with path.open("x", newline="", encoding="utf-8") as file:
            table = csv.writer(file)
            table.writerow(COLUMNS)
            for number, one in enumerate(utterances, 1):
                row = [number, *_times(one).values(), one.heard, one.command, one.command]
                table.writerow(row)
    except FileExistsError as error:
        words = f"{path} exists already; name it or another with --corrections"
        raise ManifestError(words) from error
    except OSError as error:
        raise ManifestError(f"{path} cannot be written: {error.strerror}") from error


def _times(one: SpokenUtterance) -> dict[str, str]:
    """The columns that tell one utterance from those of other sessions."""
    return {"time": f"{one.time:.2f}", "seconds": f"{len(one.samples) / RATE:.2f}"}


def _corrected(
    session: Path, path: Path, utterances: Sequence[SpokenUtterance], phrases: Sequence[str]
) -> list[RecordedTake]:
    takes, by_number = [], {str(number): one for number, one in enumerate(utterances, 1)}
    for row, (number, said, *times) in csv_rows(path, "number", "said", "time", "seconds"):
        words = " ".join(normalize(said))
        if not words:
            continue
        if number.strip() not in by_number:
            allowed = f"allowed: 1 to {len(utterances)}"
            raise ManifestError(f"{path}, row {row}: number {number!r}, {allowed}")
        one = by_number[number.strip()]
        for (column, expected), found in zip(_times(one).items(), times, strict=True):
            if not _is_same(found, expected):
                allowed = f"allowed: {expected}, as in {session}; was it written for another one?"
                raise ManifestError(f"{path}, row {row}: {column} {found!r}, {allowed}")
        phrase = with_same_words(said, phrases)
        if words != TALK and not phrase:
            allowed = ", ".join((*phrases, TALK))
            raise ManifestError(f"{path}, row {row}: said {said!r}, allowed: {allowed}, or nothing")
        kind = TALK if words == TALK else COMMAND
        samples = frozen_samples(np.asarray(one.samples, np.int16))
        name = f"{session.resolve().parent.name}/{session.name} {number.strip()}"
        takes.append(RecordedTake(name, kind, phrase, samples))
    if not takes:
        raise ManifestError(f"{path}: the column said is empty; write a command or talk there")
    return takes


def _is_same(found: str, expected: str) -> bool:
    """Whether a cell is a number as it was written; a spreadsheet leaves out zeros at its end."""
    try:
        return float(found) == float(expected)
    except ValueError:
        return False
