# SPDX-License-Identifier: BSD-3-Clause
"""Names and makes the folder of a session."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

from session_log.errors import RecordingFailed
from session_log.mcap_file.writer import SessionWriter
from typed_config import repository

FILE_NAME = "session.mcap"


def sessions_folder(named: str) -> Path:
    """Folder of all sessions: the named one; empty: that of the repository, or of the home folder.

    Packages in an install space belong to no repository.
    """
    if named:
        return Path(named).expanduser().absolute()
    return (repository("session_log") or Path.home()) / "sessions"


def open_session(folder: Path, name: str, started: int) -> SessionWriter:
    """Create `folder/name/session.mcap`, or the next free name beside it.

    Args:
        folder: Folder of all sessions; made if it is not there.
        name: Name of this session; empty for its local time.
        started: When the session started [ns] since 1970.

    Raises:
        RecordingFailed: The folder or the file cannot be made.
    """
    chosen = name or datetime.fromtimestamp(started * 1e-9).strftime("%Y-%m-%dT%H-%M-%S")
    path = folder / chosen / FILE_NAME
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RecordingFailed(path, error) from error
    return SessionWriter(_free(path))


def _free(path: Path) -> Path:
    """Return the path, numbered if a recording has it already, so that none is overwritten."""
    number = 1
    free = path
    while free.exists():
        number += 1
        free = path.with_name(f"{path.stem}_{number}{path.suffix}")
    return free
