# SPDX-License-Identifier: BSD-3-Clause
"""The page over many sessions."""

from __future__ import annotations

import math
from datetime import datetime
from pathlib import Path

from session_log.report import page
from session_log.report.figures import POOL_FIGURES
from session_log.report.one_session import latency_source
from session_log.report.pool.pool import Pool
from session_log.report.tables import pool_tables
from session_log.report.tables.folder_tables import sessions_table, unread_table
from session_log.report.tables.text_table import duration_words, length, newtons, percent, seconds

SESSIONS_NOTE = (
    "Right: phrases taken as they were meant. Action: median time from the end of speech. RCM: "
    "largest error while moving, by the controller and from the joint states. Tension: largest. "
    "Margin: smallest to a joint limit. Late: share of late cycles of the fast topics. Coloured: "
    "recordings that were not closed, are damaged or lack messages."
)


def folder_page(pool: Pool, images: dict[str, page.Image], folder: Path) -> str:
    """Set the page that will lie in `folder`."""
    title = f"{len(pool.members)} sessions"
    parts = [page.title_block(title, _subtitle(pool)), *_unread(pool), page.facts(_facts(pool))]
    for figure in POOL_FIGURES:
        if figure.name == "confusion" and figure.name not in images:
            continue  # the accuracy's place says why
        parts.append(page.heading(figure.title))
        if figure.name in images:
            parts.append(page.figure(images[figure.name]))
            parts += _table_below(figure.name, pool)
        else:
            parts.append(page.paragraph(figure.lacking, "quiet"))
    parts += [page.heading("Motion"), page.table(pool_tables.motion_table(pool))]
    parts += [page.heading("What was refused, and why"), _refused(pool)]
    parts += [page.heading("Sessions"), page.paragraph(SESSIONS_NOTE, "quiet")]
    parts.append(page.table(sessions_table(pool, folder)))
    if pool.unread:
        parts += [page.heading("Not readable"), page.table(unread_table(pool))]
    return page.page(title, parts)


def _subtitle(pool: Pool) -> str:
    times = [m.started for m in pool.members if m.started]
    words = [f"{duration_words(pool.duration)} in all"]
    if times:
        first, last = (f"{datetime.fromtimestamp(t):%d %B %Y}" for t in (min(times), max(times)))
        words.insert(0, first if first == last else f"{first} to {last}")
    return " · ".join([*words, _software(pool)])


def _software(pool: Pool) -> str:
    if len(pool.commits) > 1:
        return f"{len(pool.commits)} versions of the software"
    return f"software {next(iter(pool.commits))[:12]}"


def _unread(pool: Pool) -> list[str]:
    if not pool.unread:
        return []
    count = len(pool.unread)
    words = f"{count} recordings are" if count > 1 else "One recording is"
    return [page.paragraph(f"{words} not readable and not counted; see the end.", "warn")]


def _facts(pool: Pool) -> dict[str, str]:
    action = pool.latencies().action
    facts = {
        "commands, spoken and by hand": str(sum(pool.outcomes.values())),
        "refused": str(pool.outcomes["refused"]),
        "speech that did nothing": str(pool.ignored),
    }
    _, total, share = pool.accuracy()
    if total:
        facts[f"of {total} commands taken as meant"] = percent(share.value)
    if action:
        facts["end of speech to action, mean"] = seconds(sum(action) / len(action))
    if pool.rcm.count:
        facts["largest RCM error while moving"] = length(pool.rcm.largest)
    if math.isfinite(pool.tension):
        facts["largest tension"] = newtons(pool.tension)
    return facts


def _table_below(name: str, pool: Pool) -> list[str]:
    if name == "accuracy":
        return [page.table(pool_tables.accuracy_table(pool))]
    if name == "confusion":
        return []  # the figure says it all
    return [
        page.table(pool_tables.latency_table(pool)),
        page.paragraph(latency_source(pool), "quiet"),
    ]


def _refused(pool: Pool) -> str:
    if not pool.refusals:
        return page.paragraph("Nothing was refused.", "quiet")
    return page.table(pool_tables.refusals_table(pool))
