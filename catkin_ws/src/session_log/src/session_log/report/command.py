# SPDX-License-Identifier: BSD-3-Clause
"""The subcommand `session_log report`: over one session, or over all that are named or found."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from session_log.config import ReportConfig
from session_log.errors import SessionLogError
from session_log.mcap_file.reader import SessionReader
from session_log.mcap_file.session_folder import recordings, report_folder
from typed_config import count_option, numbered_recordings

if TYPE_CHECKING:  # the report's own modules load matplotlib and scipy: not for an error's sake
    from session_log.report.many_sessions import FolderReport
    from session_log.report.one_session import Report


def run(arguments: argparse.Namespace, config: ReportConfig) -> int:
    """Write the report and print what was written; gives 1 where a session or its page is missing.

    Raises:
        SessionLogError: Something named is not there or not readable, or --out is not writable.
    """
    if arguments.no_sound:
        config = replace(config, utterance_sound=False)
    named: list[Path] = arguments.sessions
    if len(named) == 1 and (not named[0].is_dir() or numbered_recordings(named[0])):
        report: Report = _one(named[0], arguments, config)
        is_whole = True
    else:
        report = many = _many(named, arguments, config)
        is_whole = not (many.unread or many.unwritten)
    for path in (report.page, *report.figures, *report.latex):
        print(path)
    return 0 if is_whole else 1


def _one(path: Path, arguments: argparse.Namespace, config: ReportConfig) -> Report:
    reader = SessionReader(path)
    if arguments.cluster:
        raise SessionLogError(f"--cluster needs a folder of sessions, {path} is one session")
    from session_log.report.one_session import write_report

    out = arguments.out or report_folder(reader.path)
    return write_report(reader, out, config, latex=arguments.latex)


def _many(named: list[Path], arguments: argparse.Namespace, config: ReportConfig) -> FolderReport:
    if arguments.out is None and len(named) > 1:
        words = f"{len(named)} inputs and no place for the report over them: give --out DIR"
        raise SessionLogError(words)
    recordings(named)  # whatever is not there is named at once
    from session_log.report.many_sessions import write_folder_report

    report = write_folder_report(
        named,
        arguments.out or named[0],
        config,
        beside=arguments.out is None,
        with_pages=not arguments.no_pages,
        jobs=arguments.jobs,
        cluster=arguments.cluster,
        latex=arguments.latex,
    )
    for unread in report.unread:
        print(f"not read: {unread.path}: {unread.reason}", file=sys.stderr)
    lost = f", {report.unwritten} without their page" if report.unwritten else ""
    print(f"{report.sessions} sessions read, {len(report.unread)} not readable{lost}")
    return report


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what the subcommand takes beside its settings file."""
    parser.add_argument(
        "sessions",
        type=Path,
        nargs="+",
        metavar="SESSION|FOLDER",
        help="an MCAP file, the folder of a session, or a folder with sessions below it",
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder; default: what was named")
    parser.add_argument("--latex", action="store_true", help="also the tables, with booktabs")
    parser.add_argument(
        "--no-pages", action="store_true", help="of a folder: no page for each session of it"
    )
    parser.add_argument(
        "--no-sound", action="store_true", help="keep the sound of the utterances off the pages"
    )
    parser.add_argument(
        "--jobs",
        type=count_option,
        default=1,
        metavar="N",
        help="of a folder: processes (needs dask)",
    )
    parser.add_argument(
        "--cluster", default="", metavar="ADDRESS", help="of a folder: dask scheduler, host:port"
    )
