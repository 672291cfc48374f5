# SPDX-License-Identifier: BSD-3-Clause
"""The tables that only a report over many sessions has."""

from __future__ import annotations

import math
import os
from datetime import datetime
from pathlib import Path
from urllib.parse import quote

from session_log.report.notes import read_notes
from session_log.report.pool.pool import Pool, PooledSession
from session_log.report.tables.text_table import (
    NONE,
    TextTable,
    duration_words,
    length,
    newtons,
    seconds,
)

COLUMNS = (
    "session",
    "began",
    "length",
    "right",
    "commands",
    "refused",
    "action",
    "RCM",
    "RCM, joints",
    "tension",
    "margin",
    "late",
)


def sessions_table(pool: Pool, folder: Path) -> TextTable:
    """One row per session, in order of time, with the way to its own page."""
    members = pool.sorted_members()
    return TextTable(
        COLUMNS,
        [_row(member) for member in members],
        tuple("" if member.is_complete else "warning" for member in members),
        tuple(_link(member.page, folder) for member in members),
        tuple(range(2, len(COLUMNS))),
        is_compact=True,  # its place scrolls sideways
        words=tuple(_words(member) for member in members),
    )


def unread_table(pool: Pool) -> TextTable:
    """Recordings that could not be read, and why."""
    rows = [(str(u.path), u.reason) for u in sorted(pool.unread, key=lambda u: str(u.path))]
    return TextTable(("recording", "why"), rows, ("bad",) * len(rows))


def _row(member: PooledSession) -> tuple[str, ...]:
    time = datetime.fromtimestamp(member.started).astimezone()
    began = f"{time:%Y-%m-%d %H:%M %Z}" if member.started else NONE
    margin = f"{math.degrees(member.margin):.1f}°" if math.isfinite(member.margin) else NONE
    return (
        member.name if member.is_complete else f"{member.name} (incomplete)",
        began,
        duration_words(member.duration),
        f"{member.right}/{member.said}" if member.said else NONE,
        str(member.commands),
        str(member.refused),
        seconds(member.action),
        length(member.rcm),
        length(member.rcm_joints),
        newtons(member.tension),
        margin,
        f"{member.late / member.cycles * 100:.2g}\u00a0%" if member.cycles else NONE,
    )


def _words(member: PooledSession) -> str:
    return " ".join([member.words, *(note.words for note in read_notes(member.path))])


def _link(page: Path | None, folder: Path) -> str:
    if page is None:
        return ""
    return quote(os.fsencode(os.path.relpath(page.resolve(), folder.resolve())))
