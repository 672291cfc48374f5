# SPDX-License-Identifier: BSD-3-Clause
"""Names the folder of a session and the recordings in it."""

from __future__ import annotations

import fnmatch
import os
from collections.abc import Iterable, Iterator
from datetime import datetime
from pathlib import Path
from typing import NoReturn

from session_log.errors import RecordingFailed, SessionMissing
from session_log.mcap_file.records import MAGIC
from session_log.mcap_file.writer import SessionWriter
from typed_config import RECORDING, number_of, numbered_recordings, repository

MCAP = "*.mcap"
RECOVERED = "_recovered"  # at the end of the name of a recovered copy


def sessions_folder(named: str) -> Path:
    """Folder of all sessions: the named one; empty: that of the repository, or of the home folder.

    Packages in an install space belong to no repository.
    """
    if named:
        return Path(named).expanduser().absolute()
    return (repository("session_log") or Path.home()) / "sessions"


def open_session(folder: Path, name: str, started: int, suffix: str = "") -> SessionWriter:
    """Create `folder/name/session.mcap`, or the next number beside it.

    Args:
        folder: Folder of all sessions; made if it is not there.
        name: Name of this session; empty for its local time.
        started: When the session started [ns] since 1970.
        suffix: Of a name that is the time.

    Raises:
        RecordingFailed: The folder or the file cannot be made.
    """
    time = datetime.fromtimestamp(started * 1e-9).strftime("%Y-%m-%dT%H-%M-%S")
    chosen = name or time + suffix
    path = folder / chosen / RECORDING
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        free = _free(path)
    except OSError as error:
        raise RecordingFailed(path, error) from error
    return SessionWriter(free)


def recordings(inputs: Iterable[Path]) -> list[Path]:
    """Every recording that is named or lies below a named folder, each once, in order of name.

    Of an original and its recovered copy, a search takes the original. Where that does not begin
    as a recording does, it takes the copy.

    Raises:
        SessionMissing: Something named is not there or holds no recording, or a folder below it
            cannot be read.
    """
    found: dict[Path, Path] = {}
    for path in inputs:
        if not path.exists():
            raise SessionMissing(path, "no such file or folder")
        below = [path] if path.is_file() else _originals(_all_below(path))
        if not below:
            raise SessionMissing(path, "a folder without any recording (*.mcap) in or below it")
        for recording in below:
            found.setdefault(recording.resolve(), recording)
    return list(found.values())


def session_name(recording: Path) -> str:
    """Name of a recording: that of its folder, numbered where it is not the first of it."""
    number = number_of(recording)
    if number is None:
        return recording.stem
    name = recording.resolve().parent.name
    return name if number == 1 else f"{name} ({number})"


def report_folder(recording: Path) -> Path:
    """Where the report of a recording goes: beside it, below its name where others lie there."""
    folder = recording.parent
    if recording.name == RECORDING:
        return folder
    mine = recording.resolve()
    beside = (r for r in folder.glob(MCAP) if r.is_file() and not _is_copy(r))
    has_others = _is_copy(recording) or any(r.resolve() != mine for r in beside)
    return folder / recording.stem if has_others else folder


def _all_below(folder: Path) -> Iterator[Path]:
    """All recordings in and below a folder, linked ones too; what cannot be read is refused."""
    seen = {folder.resolve()}  # a link may lead back
    for path, folders, names in os.walk(folder, onerror=_refuse, followlinks=True):
        new = {name: Path(path, name).resolve() for name in folders}
        folders[:] = [name for name in sorted(folders) if new[name] not in seen]
        seen.update(new.values())
        yield from (Path(path, name) for name in fnmatch.filter(names, MCAP))


def _refuse(error: OSError) -> NoReturn:
    raise SessionMissing(Path(error.filename), error.strerror or "cannot be read") from error


def _originals(found: Iterable[Path]) -> list[Path]:
    """Recordings without copies; a damaged beginning gives the place to the copy."""
    files = sorted(filter(Path.is_file, found))
    known = set(files)
    copied = (path for path in files if path.with_stem(path.stem + RECOVERED) in known)
    replaced = {path for path in copied if not _begins_as_mcap(path)}
    return [
        path
        for path in files
        if path not in replaced and (not _is_copy(path) or _original(path) in replaced)
    ]


def _is_copy(recording: Path) -> bool:
    return recording.stem.endswith(RECOVERED) and _original(recording).exists()


def _original(copy: Path) -> Path:
    return copy.with_stem(copy.stem.removesuffix(RECOVERED))


def _begins_as_mcap(path: Path) -> bool:
    try:
        with path.open("rb") as file:
            return file.read(len(MAGIC)) == MAGIC
    except OSError:
        return False


def _free(path: Path) -> Path:
    """A path after all recordings of its folder, so that the highest number is the newest."""
    last = max(numbered_recordings(path.parent), default=0)
    return path.with_name(f"{path.stem}_{last + 1}{path.suffix}") if last else path
