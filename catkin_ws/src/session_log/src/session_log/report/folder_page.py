# SPDX-License-Identifier: BSD-3-Clause
"""The page over many sessions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from datetime import datetime
from pathlib import Path

from session_log.report.figures import POOL_FIGURES
from session_log.report.page import Image, Section, page, table_section
from session_log.report.pool.pool import Pool
from session_log.report.sections import (
    FAILURES,
    OF_THEM_REFUSED,
    figure_section,
    inputs_section,
    large_facts,
)
from session_log.report.tables import pool_tables
from session_log.report.tables.folder_tables import sessions_table, unread_table
from session_log.report.tables.text_table import duration_words

SESSIONS_NOTE = (
    "Right: phrases taken as they were meant. Action: median time from the end of speech. RCM: "
    "largest error while moving, by the controller and from the joint states. Tension: largest. "
    "Margin: smallest of a turning joint to its limit. Late: share of late cycles of the fast "
    "topics. Incomplete: the recording was not closed, is damaged, lacks messages or holds some "
    "that do not fit. Also incomplete: topics in namespaces, and clocks that were set back or are "
    "off."
)
SEARCH = "search words, refusals, notes, dates"


def folder_page(pool: Pool, images: Mapping[str, Image], folder: Path) -> str:
    """Set the page that will lie in `folder`."""
    commands = {
        "commands, spoken and by hand": sum(pool.outcomes.values()),
        OF_THEM_REFUSED: pool.outcomes["refused"],
    }
    return page(
        f"{len(pool.members)} sessions",
        _subtitle(pool),
        _warning(pool),
        large_facts(pool, commands),
        _sections(pool, images, folder),
    )


def _sections(pool: Pool, images: Mapping[str, Image], folder: Path) -> Iterator[Section]:
    table = sessions_table(pool, folder)
    yield Section("Sessions", SESSIONS_NOTE, table=table, search=SEARCH)
    for figure in POOL_FIGURES:
        if figure.name != "confusion" or figure.name in images:  # else the accuracy's says why
            yield figure_section(figure, images, pool)
    yield Section("Motion", table=pool_tables.motion_table(pool))
    if len(pool.inputs) > 1:
        yield inputs_section(pool)
    refused = pool_tables.reasons_table(pool.refusals)
    yield table_section("What was refused, and why", refused, "Nothing was refused.")
    if pool.failures:
        yield Section(FAILURES, table=pool_tables.reasons_table(pool.failures))
    if pool.unread:
        yield Section("Not readable", table=unread_table(pool))


def _subtitle(pool: Pool) -> str:
    times = [m.started for m in pool.members if m.started]
    words = [f"{duration_words(pool.duration)} in all"]
    if times:
        first, last = (_day(t) for t in (min(times), max(times)))
        words.insert(0, first if first == last else f"{first} to {last}")
    return " · ".join([*words, _software(pool)])


def _day(time: float) -> str:
    return f"{datetime.fromtimestamp(time).astimezone():%d %B %Y %Z}"


def _software(pool: Pool) -> str:
    if len(pool.commits) > 1:
        return f"{len(pool.commits)} versions of the software"
    return f"software {next(iter(pool.commits))[:12]}"


def _warning(pool: Pool) -> str:
    count = len(pool.unread)
    words = f"{count} recordings are" if count > 1 else "One recording is"
    return f"{words} not readable and not counted; see the end." if count else ""
