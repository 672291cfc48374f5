# SPDX-License-Identifier: BSD-3-Clause
"""Which file of a session's folder is its recording: the newest, where one name was used again."""

from __future__ import annotations

import logging
import re
from pathlib import Path

RECORDING = "session.mcap"  # of the first; a second of the same name is session_2.mcap
_NUMBERED = re.compile(r"session(?:_(\d+))?\.mcap")

log = logging.getLogger(__name__)


def number_of(recording: Path) -> int | None:
    """Number of a recording in its session's folder, from 1; None for other names of files."""
    match = _NUMBERED.fullmatch(recording.name)
    return int(match[1] or 1) if match else None


def numbered_recordings(folder: Path) -> dict[int, Path]:
    """Recordings of one session's folder by number, the newest last; recovered copies are none."""
    entries = folder.iterdir() if folder.is_dir() else ()
    found = {number: path for path in entries if (number := number_of(path)) is not None}
    return dict(sorted(found.items()))


def newest_recording(folder: Path) -> Path | None:
    """The newest recording of a session's folder, and a word where there are others; or None."""
    found = list(numbered_recordings(folder).values())
    if len(found) > 1:
        log.warning("%s: the newest of %d recordings in this folder", found[-1], len(found))
    return found[-1] if found else None
