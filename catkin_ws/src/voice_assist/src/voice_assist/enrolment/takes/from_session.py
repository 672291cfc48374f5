# SPDX-License-Identifier: BSD-3-Clause
"""Takes from a recorded session, after a person has said what was really said in it.

The recording is read by a function that a setting names, so that neither package knows the other.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from voice_assist.enrolment.takes.checks import Checked
from voice_assist.enrolment.takes.script import EnrolmentScript
from voice_assist.errors import ManifestError, VoiceError
from voice_assist.profile.manifest import COMMAND, TALK
from voice_assist.text.normalize import normalize
from voice_assist.types import RATE, Samples, frozen_samples

COLUMNS = ("number", "time", "seconds", "heard", "command", "said")


class SpokenUtterance(Protocol):
    """One recorded utterance."""

    @property
    def time(self) -> float: ...  # noqa: D102 - [s] since the session began
    @property
    def heard(self) -> str: ...  # noqa: D102
    @property
    def command(self) -> str: ...  # noqa: D102 - taken; empty: none
    @property
    def samples(self) -> NDArray[np.int16]: ...  # noqa: D102 - (n,), 16 kHz mono


@dataclass(frozen=True, eq=False)
class SessionTake:
    """An utterance of which it is known what was said."""

    name: str  # of session and utterance
    kind: str
    phrase: str
    samples: Samples


class Uncorrected(VoiceError):
    """Nobody has said yet what was really said."""


def read_takes(
    session: Path, corrections: Path | None, phrases: Sequence[str], reader: str
) -> list[SessionTake]:
    """Utterances of a recording with what a person wrote for them.

    Args:
        session: An MCAP file, or the folder of a session.
        corrections: CSV with the column `said`; made for filling in where it does not exist.
        phrases: Of all commands.
        reader: `module:function` that reads recordings.

    Raises:
        Uncorrected: The file was just made; says what to do with it.
        ManifestError: The recording or the file cannot be used.
    """
    utterances = _read(session, reader)
    if corrections is None or not corrections.exists():
        path = corrections or Path("corrections.csv")
        _write(path, utterances)
        words = "the column said: a command, talk, or nothing for what shall be left out"
        raise Uncorrected(f"{path} was written; correct {words}; then --corrections {path}")
    return _corrected(session, corrections, utterances, phrases)


def take_over(
    script: EnrolmentScript,
    takes: Iterable[SessionTake],
    on_checked: Callable[[Path, Checked], None],
) -> int:
    """Offer takes to a script; gives how many were kept."""
    before = script.kept
    for take in takes:
        checked = script.take_over(take.kind, take.phrase, take.samples, take.name)
        if checked is not None:
            on_checked(Path(take.name), checked)
    return script.kept - before


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
                times = f"{one.time:.2f}", f"{len(one.samples) / RATE:.2f}"
                table.writerow([number, *times, one.heard, one.command, one.command])
    except OSError as error:
        raise ManifestError(f"{path} cannot be written: {error.strerror}") from error


def _corrected(
    session: Path, path: Path, utterances: Sequence[SpokenUtterance], phrases: Sequence[str]
) -> list[SessionTake]:
    takes = []
    for row, number, said in _rows(path):
        words = " ".join(normalize(said))
        if not words:
            continue
        if not 1 <= number <= len(utterances):
            allowed = f"allowed: 1 to {len(utterances)}"
            raise ManifestError(f"{path}, row {row}: number {number}, {allowed}")
        if words != TALK and words not in phrases:
            allowed = ", ".join((*phrases, TALK))
            raise ManifestError(f"{path}, row {row}: said {said!r}, allowed: {allowed}, or nothing")
        kind, phrase = (TALK, "") if words == TALK else (COMMAND, words)
        samples = frozen_samples(np.asarray(utterances[number - 1].samples, np.int16))
        name = f"{session.resolve().parent.name}/{session.name} {number}"
        takes.append(SessionTake(name, kind, phrase, samples))
    return takes


def _rows(path: Path) -> list[tuple[int, int, str]]:
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = csv.DictReader(file)
            missing = {"number", "said"} - set(rows.fieldnames or ())
            if missing:
                raise ManifestError(f"{path}: no column {', '.join(sorted(missing))}")
            return [(rows.line_num, int(row["number"]), row["said"] or "") for row in rows]
    except (OSError, UnicodeDecodeError, csv.Error, ValueError, TypeError) as error:
        raise ManifestError(f"{path}: cannot be read ({error})") from error
