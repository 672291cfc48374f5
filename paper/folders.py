# SPDX-License-Identifier: BSD-3-Clause
"""One folder per session; what is finished is kept, what is not is set aside and begun anew."""

from __future__ import annotations

import datetime
import json
from dataclasses import asdict
from pathlib import Path

from paper.config import ExperimentConfig, PaperVoiceConfig

FINISHED = "finished.json"
CODE = "code.txt"
ASIDE = "unfinished"  # folder beside that of the experiment


def settings_of(config: ExperimentConfig, voice: PaperVoiceConfig | None, repetitions: int) -> str:
    """All that decides how the session of a voice goes, as JSON; None: of the pedal."""
    settings = asdict(config)
    del settings["voices"]
    who = asdict(voice) if voice else "pedal"
    return json.dumps({**settings, "repetitions": repetitions, "voice": who}, indent=1)


def is_finished(folder: Path, settings: str) -> bool:
    """Tell whether a session was played to its end with these settings."""
    path = folder / FINISHED
    return path.is_file() and path.read_text(encoding="utf-8") == settings


def finish(folder: Path, settings: str) -> None:
    """Mark a session as played to its end."""
    (folder / FINISHED).write_text(settings, encoding="utf-8")


def note_code(folder: Path, code: str) -> None:
    """Keep of which code a session is, beside what it leaves."""
    (folder / CODE).write_text(code, encoding="utf-8")


def code_of(folder: Path) -> str:
    """Of which code a session is; empty: that was not kept."""
    path = folder / CODE
    return path.read_text(encoding="utf-8") if path.is_file() else ""


def set_aside(folder: Path) -> Path | None:
    """Move a session out of the way, so that it is in no sum but not lost either.

    Returns:
        Where it is now; None when there was none.
    """
    if not folder.exists():
        return None
    now = datetime.datetime.now().strftime("%Y-%m-%d_%H-%M-%S")
    place = folder.parent.with_name(f"{folder.parent.name}_{ASIDE}") / f"{folder.name}_{now}"
    place.parent.mkdir(parents=True, exist_ok=True)
    return folder.rename(place)
