# SPDX-License-Identifier: BSD-3-Clause
"""Makes the report of one session: an HTML page, its figures as PNG files, its tables for LaTeX."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from session_log.config import ReportConfig
from session_log.errors import OutputFailed
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.session_folder import session_name
from session_log.report.figures import POOL_FIGURES, SESSION_FIGURES, SessionMaterial
from session_log.report.figures.drawing import draw
from session_log.report.notes import Note, read_notes
from session_log.report.pool import cache
from session_log.report.pool.pool import Pool
from session_log.report.session.analysis import command_rows
from session_log.report.session.extract import extract
from session_log.report.session.shaft import rcm_from_joints
from session_log.report.session.summary import SessionSummary, summarise
from session_log.report.session_page import session_page
from session_log.report.tables.latex import write_latex
from typed_config import check_writable

PAGE_NAME = "report.html"


@dataclass(frozen=True)
class Report:
    """What was written."""

    page: Path
    figures: list[Path]
    latex: list[Path] = field(default_factory=list)


@dataclass(frozen=True)
class _Session:
    """A session, read and reduced."""

    material: SessionMaterial
    summary: SessionSummary
    pool: Pool  # of this session alone
    notes: tuple[Note, ...]
    key: dict[str, object]  # what its page depends on


def write_report(
    reader: SessionReader, folder: Path, config: ReportConfig, *, latex: bool = False
) -> Report:
    """Read a session and write `report.html` and one PNG per figure.

    Args:
        reader: The recording, sound or not.
        folder: Where to write; made if it is not there.
        config: Settings of the report.
        latex: Also write the tables as .tex files.

    Raises:
        OutputFailed: The folder cannot be written; that is tried before the session is read.
    """
    require_writable(folder)
    session = _read(reader, config)
    try:
        return _write(session, folder, config, latex)
    except OSError as error:
        raise not_written(folder, error) from error


def require_writable(folder: Path) -> None:
    """Find out before long work whether a folder takes a page; makes it if it is not there.

    Raises:
        OutputFailed: It does not.
    """
    try:
        check_writable(folder / PAGE_NAME)
    except OSError as error:
        raise not_written(folder, error) from error


def not_written(folder: Path, cause: OSError) -> OutputFailed:
    """The error of a folder that cannot be written, with the way out."""
    words = f"{cause.strerror or type(cause).__name__}; --out DIR writes elsewhere"
    return OutputFailed(folder, OSError(cause.errno, words))


def reduce_session(
    path: Path, folder: Path, config: ReportConfig, *, with_page: bool
) -> tuple[SessionSummary, str]:
    """Return the summary of a session: from its cache if that is still true, else by reading it.

    With it comes why it or the page could not be kept; empty: both are.

    Args:
        path: The recording.
        folder: Where summary and page are kept; made if it is not there.
        config: Settings of the report.
        with_page: Also write the session's own page, unless it is there and still true.

    Raises:
        SessionLogError: The recording cannot be read.
    """
    key = cache.key_of(path, config, read_notes(path))
    known = cache.load(folder, key)
    if known is not None and (not with_page or cache.is_page_of(folder / PAGE_NAME, key)):
        return known, ""
    session = _read(SessionReader(path), config)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if with_page:
            _write(session, folder, config, latex=False)
        cache.store(folder, key, session.summary)
    except OSError as error:
        return session.summary, str(not_written(folder, error))
    return session.summary, ""


def _read(reader: SessionReader, config: ReportConfig) -> _Session:
    notes = read_notes(reader.path)
    key = cache.key_of(reader.path, config, notes)  # before: the file may grow meanwhile
    data = extract(reader, config)
    rows, rcm = command_rows(data, config), rcm_from_joints(data, config)
    summary = summarise(session_name(reader.path), data, rows, rcm, config)
    pool = Pool(config)
    pool.add(reader.path, None, summary)
    material = SessionMaterial(data, rows, config, rcm, summary.trials)
    return _Session(material, summary, pool, notes, key)


def _write(session: _Session, folder: Path, config: ReportConfig, latex: bool) -> Report:
    images, written = draw(SESSION_FIGURES, session.material, folder, config)
    pooled, more = draw(POOL_FIGURES, session.pool, folder, config)
    target = folder / PAGE_NAME
    text = session_page(
        session.material, session.summary.name, session.pool, images | pooled, session.notes
    )
    write_page(target, cache.marked(text, session.key))
    tex = write_latex(session.pool, folder) if latex else []
    return Report(target, written + more, tex)


def write_page(target: Path, text: str) -> None:
    """Write a page; bytes of a file's name that are no UTF-8 stand in it as numbers.

    Raises:
        OSError: It cannot be written.
    """
    target.write_text(text, encoding="utf-8", errors="backslashreplace")
