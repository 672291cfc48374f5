# SPDX-License-Identifier: BSD-3-Clause
"""Keeps the summary of a session beside its page, so that a folder is read only once."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path

from session_log.config import ReportConfig
from session_log.mcap_file.session_folder import session_name
from session_log.report.notes import Note
from session_log.report.session.summary import SessionSummary, from_json

FILE_NAME = "report_summary.json"
_MARK = "<!-- made with {} -->\n"  # the last line of a page
VERSION = 14  # of what a summary holds and of how it is computed; raise it when either changes


def key_of(recording: Path, config: ReportConfig, notes: Sequence[Note]) -> dict[str, object]:
    """What a summary and its page depend on: name, file, notes, settings, the code's version.

    Raises:
        OSError: There is no such recording.
    """
    state = recording.stat()
    settings = json.dumps(asdict(config), sort_keys=True).encode()
    return {
        "version": VERSION,
        "name": session_name(recording),
        "recording": recording.name,
        "size": state.st_size,
        "modified": state.st_mtime_ns,
        "settings": sha256(settings).hexdigest()[:16],
        "notes": sha256(repr(notes).encode()).hexdigest()[:16],
    }


def marked(page: str, key: dict[str, object]) -> str:
    """The text of a page, and behind it the key that it was made with."""
    return page + _mark(key)


def is_page_of(page: Path, key: dict[str, object]) -> bool:
    """Whether there is a page, and it was made with this key."""
    mark = _mark(key).encode()
    try:
        with page.open("rb") as file:
            file.seek(max(file.seek(0, os.SEEK_END) - len(mark), 0))
            return file.read() == mark
    except OSError:
        return False


def _mark(key: dict[str, object]) -> str:
    return _MARK.format(sha256(json.dumps(key, sort_keys=True).encode()).hexdigest())


def load(folder: Path, key: dict[str, object]) -> SessionSummary | None:
    """Return the summary kept in a folder; None if there is none for this key."""
    try:
        kept = json.loads((folder / FILE_NAME).read_text(encoding="utf-8"))
        return from_json(kept["summary"]) if kept["key"] == key else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def store(folder: Path, key: dict[str, object], summary: SessionSummary) -> None:
    """Keep a summary; whole or not at all.

    Raises:
        OSError: The folder cannot be written.
    """
    target = folder / FILE_NAME
    draft = target.with_suffix(f".{os.getpid()}")
    draft.write_text(json.dumps({"key": key, "summary": asdict(summary)}), encoding="utf-8")
    draft.replace(target)
