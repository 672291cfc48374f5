# SPDX-License-Identifier: BSD-3-Clause
"""What was said, phrase by phrase, kept beside the recording as one JSON line each."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

FILE = "trials.jsonl"


@dataclass(frozen=True)
class SpokenTrial:
    """One phrase that was played."""

    index: int
    command: str  # meant; empty: none
    words: str
    sound: str  # name of its WAV in the folder
    began: float  # [s] since 1970, when its player was started
    ended: float  # [s] since 1970, when the player had ended
    rate: float
    pitch: float
    is_counted: bool
    interrupts: str  # motion in which this "stop" was said; empty: said at rest


def append(folder: Path, trial: SpokenTrial) -> None:
    """Keep a trial."""
    with (folder / FILE).open("a", encoding="utf-8") as file:
        file.write(json.dumps(asdict(trial)) + "\n")


def read(folder: Path) -> list[SpokenTrial]:
    """Read the trials of a session; none when there is no such file.

    A session that was killed leaves half a last line, which is none.
    """
    path = folder / FILE
    if not path.is_file():
        return []
    *lines, _ = path.read_text(encoding="utf-8").split("\n")
    return [SpokenTrial(**json.loads(line)) for line in lines]
