# SPDX-License-Identifier: BSD-3-Clause
"""What came of each phrase: what was taken, and how long decision and robot needed.

What was heard, answered and done is found by session_log, as in its report. Only the end of each
phrase is not taken from the speech detector; see truth.py.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import soundfile

from paper.judging import truth
from paper.judging.trials import SpokenTrial, read
from session_log.config import ReportConfig
from session_log.mcap_file.reader import SessionReader
from session_log.report.session.analysis import CommandRow, command_rows
from session_log.report.session.extract import extract

FILE = "outcomes.json"
LATEST = 4.0  # [s] after the end of the player in which decisions belong to a phrase


@dataclass(frozen=True)
class PhraseOutcome:
    """One phrase and what came of it; times in seconds after its true end, nan where there is none.

    A decision made while the phrase still sounds has a negative time.
    """

    command: str  # meant; empty: none
    words: str
    taken: tuple[str, ...]  # commands that were heard
    refusal: str  # the controller's; empty: none
    is_counted: bool
    is_whole: bool  # False: the player tore the sound apart, which says nothing about the system
    decided: float  # [s]
    acted: float  # [s] the robot moves, or answers where nothing is to be moved

    @property
    def is_correct(self) -> bool:
        """Whether what was meant was taken, and nothing else."""
        return self.taken == ((self.command,) if self.command else ())


def judge(folder: Path, report: ReportConfig) -> list[PhraseOutcome]:
    """Judge every phrase of a session, and keep that beside the recording.

    Args:
        folder: Of the session.
        report: Settings of session_log.

    Raises:
        SessionMissing: There is no recording.
    """
    trials, sound = read(folder), truth.captured_sound(folder)
    data = extract(SessionReader(folder), report)
    zero = data.recording.start * 1e-9
    rows, found = command_rows(data, report), []
    for trial, following in zip(trials, [*trials[1:], None], strict=True):
        phrase, _ = soundfile.read(folder / trial.sound, dtype="float32")
        heard = truth.find(phrase, sound, trial.began, trial.ended)
        until = min(trial.ended + LATEST, following.began if following else math.inf)
        mine = [r for r in rows if r.heard and trial.began <= r.heard.decision + zero < until]
        found.append(outcome(trial, heard.end - zero if heard else math.nan, mine))
    keep(folder, found)
    return found


def keep(folder: Path, outcomes: Sequence[PhraseOutcome]) -> None:
    """Keep the outcomes of a session beside its recording."""
    text = json.dumps([asdict(o) for o in outcomes], indent=1)
    (folder / FILE).write_text(text + "\n", encoding="utf-8")


def kept(folder: Path) -> list[PhraseOutcome]:
    """Read the outcomes of a session that was judged; none when it was not."""
    path = folder / FILE
    if not path.is_file():
        return []
    entries = json.loads(path.read_text(encoding="utf-8"))
    return [PhraseOutcome(**{**entry, "taken": tuple(entry["taken"])}) for entry in entries]


def outcome(trial: SpokenTrial, end: float, rows: Sequence[CommandRow]) -> PhraseOutcome:
    """Judge one phrase.

    Args:
        trial: The phrase.
        end: Of its sound, on the clock of the rows [s]; nan: it was not heard whole.
        rows: Commands that were taken in its time, with what the robot did.
    """
    row = next((r for r in rows if r.command == trial.command), None)
    decided = acted = math.nan
    if row is not None and row.heard is not None:
        decided = row.heard.decision - end
        acted = row.action - end if row.action is not None else math.nan
    return PhraseOutcome(
        command=trial.command,
        words=trial.words,
        taken=tuple(r.command for r in rows),
        refusal=row.message if row is not None and row.outcome == "refused" else "",
        is_counted=trial.is_counted,
        is_whole=math.isfinite(end),
        decided=decided,
        acted=acted,
    )
