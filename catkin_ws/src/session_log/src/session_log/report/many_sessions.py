# SPDX-License-Identifier: BSD-3-Clause
"""Makes the report over many sessions: each is reduced once, then their summaries are pooled."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from hashlib import sha256
from pathlib import Path

from session_log.config import ReportConfig
from session_log.errors import SessionLogError
from session_log.mcap_file.session_folder import recordings, report_folder, session_name
from session_log.report.figures import POOL_FIGURES
from session_log.report.figures.drawing import draw
from session_log.report.folder_page import folder_page
from session_log.report.one_session import (
    PAGE_NAME,
    Report,
    not_written,
    reduce_session,
    require_writable,
    write_page,
)
from session_log.report.pool.parallel import Unfinished, run_parallel
from session_log.report.pool.pool import Pool, UnreadSession
from session_log.report.session.summary import SessionSummary
from session_log.report.tables.latex import write_latex

PAGES_FOLDER = "sessions"  # below the output, where that is not beside the recordings

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Task:
    """One recording to reduce."""

    path: Path
    folder: Path  # of its summary and its page


@dataclass(frozen=True)
class FolderReport(Report):
    """What was written over many sessions."""

    sessions: int = 0
    unread: tuple[UnreadSession, ...] = ()
    unwritten: int = 0  # pages of sessions


class NothingReadable(SessionLogError):
    """None of the recordings that were named can be read."""

    def __init__(self, unread: Sequence[UnreadSession]) -> None:
        reasons = "; ".join(u.reason for u in unread[:3])
        more = f"; and {len(unread) - 3} more" if len(unread) > 3 else ""
        super().__init__(f"none of {len(unread)} recordings can be read: {reasons}{more}")


def write_folder_report(
    inputs: Sequence[Path],
    out: Path,
    config: ReportConfig,
    *,
    beside: bool = False,
    with_pages: bool = True,
    jobs: int = 1,
    cluster: str = "",
    latex: bool = False,
) -> FolderReport:
    """Write the report over every recording that is named or lies below a named folder.

    Args:
        inputs: MCAP files and folders; a folder is searched to any depth.
        out: Where the page and its figures go; made if it is not there.
        config: Settings of the report.
        beside: Keep each session's page and summary beside its recording, not below `out`.
        with_pages: Also write each session's own page.
        jobs: Processes on this machine, at most one per recording; more than one needs
            dask.distributed.
        cluster: Address of a dask scheduler to use instead; its workers must see the same
            files under the same names. Empty for none.
        latex: Also write the tables as .tex files.

    Raises:
        SessionMissing: Something named is not there, or holds no recording.
        NothingReadable: There are recordings, but none can be read.
        EngineMissing, EngineUnreachable: See `run_parallel`.
        OutputFailed: The output cannot be written; that is tried before a session is read.
    """
    tasks = list(_tasks(recordings(inputs), out, beside=beside))
    require_writable(out)
    pool, unwritten = Pool(config), 0
    work = partial(_reduce, config=config, with_page=with_pages)
    for done in run_parallel(work, tasks, min(jobs, len(tasks)), cluster):
        if isinstance(done, Unfinished):
            pool.unread.append(UnreadSession(done.item.path, done.reason))
        elif isinstance(done, UnreadSession):
            pool.unread.append(done)
        else:
            task, summary, trouble = done
            if trouble:
                log.warning("%s: read and counted, but %s", task.path, trouble)
                unwritten += with_pages
            page = task.folder / PAGE_NAME
            is_there = (with_pages and not trouble) or page.exists()
            pool.add(task.path, page if is_there else None, summary)
    if not pool.members:
        raise NothingReadable(pool.unread)
    try:
        return replace(_write(pool, out, latex), unwritten=unwritten)
    except OSError as error:
        raise not_written(out, error) from error


def _tasks(paths: Iterable[Path], out: Path, *, beside: bool) -> Iterator[Task]:
    for path in paths:
        folder = report_folder(path) if beside else out / PAGES_FOLDER / _page_name(path)
        is_taken = folder.resolve() == out.resolve()  # by the page over all
        yield Task(path, folder / path.stem if is_taken else folder)


def _page_name(path: Path) -> str:
    """A name for the folder of a session's page that no other recording has."""
    full = path.resolve()
    return f"{session_name(full)}_{sha256(os.fsencode(full)).hexdigest()[:8]}"


def _reduce(
    task: Task, config: ReportConfig, with_page: bool
) -> tuple[Task, SessionSummary, str] | UnreadSession:
    """Reduce one session; whatever is wrong with it must not end the report over the others."""
    try:
        return task, *reduce_session(task.path, task.folder, config, with_page=with_page)
    except SessionLogError as error:
        return UnreadSession(task.path, str(error))
    except Exception as error:  # top of a worker
        return UnreadSession(task.path, f"{type(error).__name__}: {error}")


def _write(pool: Pool, out: Path, latex: bool) -> FolderReport:
    images, written = draw(POOL_FIGURES, pool, out, pool.config)
    target = out / PAGE_NAME
    write_page(target, folder_page(pool, images, out))
    tex = write_latex(pool, out) if latex else []
    return FolderReport(target, written, tex, len(pool.members), tuple(pool.unread))
