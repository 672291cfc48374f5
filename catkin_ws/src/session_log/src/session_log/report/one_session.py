# SPDX-License-Identifier: BSD-3-Clause
"""Makes the report of one session: an HTML page, its figures as PNG files, its tables for LaTeX."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

from session_log.config import ReportConfig
from session_log.errors import OutputFailed
from session_log.mcap_file.reader import SessionReader
from session_log.report import page
from session_log.report.figures import POOL_FIGURES, SESSION_FIGURES, ReportFigure, SessionMaterial
from session_log.report.figures.drawing import draw
from session_log.report.pool import cache
from session_log.report.pool.pool import Pool
from session_log.report.session.analysis import command_rows
from session_log.report.session.extract import extract
from session_log.report.session.shaft import rcm_from_joints
from session_log.report.session.stops import stops, stops_table
from session_log.report.session.summary import SessionSummary, summarise
from session_log.report.tables import pool_tables, session_tables
from session_log.report.tables.latex import write_latex
from session_log.report.tables.text_table import length, newtons, percent, seconds, size_words

PAGE_NAME = "report.html"
COMMANDS_NOTE = "Decision and action: time after the end of speech."
ORDER = (
    "timeline",
    "accuracy",
    "confusion",
    "latency",
    "rcm_error",
    "tension",
    "scene",
    "joints",
    "loop_timing",
)
FIGURES: dict[str, ReportFigure[SessionMaterial] | ReportFigure[Pool]] = {
    **{figure.name: figure for figure in SESSION_FIGURES},
    **{figure.name: figure for figure in POOL_FIGURES},
}


@dataclass(frozen=True)
class Report:
    """What was written."""

    page: Path
    figures: list[Path]
    latex: list[Path] = field(default_factory=list)


@dataclass(frozen=True)
class _Session:
    """A session, read and reduced."""

    name: str
    material: SessionMaterial
    summary: SessionSummary
    pool: Pool  # of this session alone


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
        OutputFailed: The folder cannot be written.
    """
    session = _read(reader, config)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return _write(session, folder, config, latex)
    except OSError as error:
        raise OutputFailed(folder, error) from error


def reduce_session(
    path: Path, folder: Path, config: ReportConfig, *, with_page: bool
) -> SessionSummary:
    """Return the summary of a session: from its cache if that is still true, else by reading it.

    Args:
        path: The recording.
        folder: Where summary and page are kept; made if it is not there.
        config: Settings of the report.
        with_page: Also write the session's own page, unless it is there.

    Raises:
        SessionLogError: The recording cannot be read, or the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        key = cache.key_of(path, config)
        known = cache.load(folder, key)
        if known is not None and (not with_page or (folder / PAGE_NAME).exists()):
            return known
        session = _read(SessionReader(path), config)
        if with_page:
            _write(session, folder, config, latex=False)
        cache.store(folder, key, session.summary)
    except OSError as error:
        raise OutputFailed(folder, error) from error
    return session.summary


def _read(reader: SessionReader, config: ReportConfig) -> _Session:
    data = extract(reader, config)
    rows, rcm = command_rows(data, config), rcm_from_joints(data, config)
    name = _name(reader)
    summary = summarise(name, data, rows, rcm, config)
    pool = Pool(config)
    pool.add(reader.path, None, summary)
    return _Session(name, SessionMaterial(data, rows, config, rcm, summary.trials), summary, pool)


def _write(session: _Session, folder: Path, config: ReportConfig, latex: bool) -> Report:
    images, written = draw(SESSION_FIGURES, session.material, folder, config)
    pooled, more = draw(POOL_FIGURES, session.pool, folder, config)
    target = folder / PAGE_NAME
    target.write_text(_page(session, images | pooled), encoding="utf-8")
    tex = write_latex(session.pool, folder) if latex else []
    return Report(target, written + more, tex)


def _page(session: _Session, images: dict[str, page.Image]) -> str:
    material, pool = session.material, session.pool
    parts = [_title(session), *_warnings(material), page.facts(_facts(session))]
    for name in ORDER:
        if name == "confusion" and name not in images:
            continue  # the accuracy's place says why
        parts.append(page.heading(FIGURES[name].title))
        if name in images:
            parts.append(page.figure(images[name]))
        else:
            parts.append(page.paragraph(FIGURES[name].lacking, "quiet"))
        parts += _tables_below(name, material, pool)
    parts += [page.heading("Health"), _health(material)]
    parts += [page.heading("Recording"), page.table(session_tables.topics_table(material))]
    parts += [page.heading("Origin"), *_origin(material)]
    return page.page(f"Session {session.name}", parts)


def _tables_below(name: str, material: SessionMaterial, pool: Pool) -> list[str]:
    if name == "timeline":
        refused = page.paragraph("Nothing was refused.", "quiet")
        if pool.refusals:
            refused = page.table(session_tables.refused_table(material))
        found = stops(material.data.events, material.data.states)
        stopped = page.paragraph("Nothing stopped the robot.", "quiet")
        if found:
            stopped = page.table(stops_table(found))
        return [
            page.heading("Commands"),
            page.paragraph(COMMANDS_NOTE, "quiet"),
            page.table(session_tables.commands_table(material)),
            page.heading("What stopped the robot, and why"),
            stopped,
            page.heading("What was refused, and why"),
            refused,
        ]
    if name == "accuracy" and pool.knows_intent:
        return [page.table(pool_tables.accuracy_table(pool))]
    if name == "latency" and pool.latencies().decision:
        return [
            page.table(pool_tables.latency_table(pool)),
            page.paragraph(latency_source(pool), "quiet"),
        ]
    return []


def latency_source(pool: Pool) -> str:
    """Say what the brackets and the paper's column of the latency table are."""
    paper = pool.config.paper
    return (
        "In brackets: exact 95 % confidence bounds, where there are values enough: 6 for a "
        f"median, 72 for a 95th percentile. Paper: {paper.source}; {paper.repetitions} of each "
        f"command on an {paper.hardware}; its time runs from the end of the request to the "
        "robot's action."
    )


def _name(reader: SessionReader) -> str:
    is_default = reader.path.name == "session.mcap"
    return reader.path.resolve().parent.name if is_default else reader.path.stem


def _title(session: _Session) -> str:
    recording = session.material.data.recording
    began = datetime.fromtimestamp(recording.start * 1e-9).astimezone() if recording.start else None
    words = began.strftime("%d %B %Y, %H:%M:%S %Z") if began else "no messages"
    extent = f"{recording.duration:.1f} s, {recording.messages} messages"
    size = size_words(recording.condition.size)
    return page.title_block(f"Session {session.name}", f"{words} · {extent} · {size}")


def _warnings(material: SessionMaterial) -> list[str]:
    recording, words = material.data.recording, []
    condition = recording.condition
    if not condition.is_closed:
        words.append("The recorder did not close this file: it was killed, or is still running.")
    if condition.checksum == "wrong":
        words.append("The file was changed after it was written: its checksum is wrong.")
    if condition.damage:
        lost = sum(damage.length for damage in condition.damage)
        words.append(f"{lost} bytes in {len(condition.damage)} places cannot be read.")
    if recording.missing:
        words.append(f"{recording.missing} messages were received but are not in the file.")
    for name, loss in condition.latest("losses").items():
        words.append(f"Lost on {name}: {loss}.")
    for topic, count in material.data.undecodable.items():
        words.append(f"{count} messages of {topic} do not fit what the report expects.")
    words += [f"Left out: {what}." for what in sorted(material.data.missing_fields)]
    return [page.paragraph(" ".join(words), "warn")] if words else []


def _facts(session: _Session) -> dict[str, str]:
    pool, summary = session.pool, session.summary
    action = pool.latencies().action
    facts = {
        "spoken commands": str(sum(1 for given in summary.given if given.is_spoken)),
        "refused": str(pool.outcomes["refused"]),
        "speech that did nothing": str(summary.ignored),
    }
    _, total, share = pool.accuracy()
    if total:
        facts[f"of {total} commands taken as meant"] = percent(share.value)
    if action:
        facts["end of speech to action, mean"] = seconds(sum(action) / len(action))
    if pool.rcm.count:
        facts["largest RCM error while moving"] = length(pool.rcm.largest)
    if math.isfinite(summary.tension):
        facts["largest tension"] = newtons(summary.tension)
    return facts


def _health(material: SessionMaterial) -> str:
    if not material.data.health:
        return page.paragraph("The recording holds no diagnostics.", "quiet")
    return page.table(session_tables.health_table(material))


def _origin(material: SessionMaterial) -> list[str]:
    latest = dict(material.data.recording.condition.metadata)
    if not latest:
        return [page.paragraph("The recording holds no metadata.", "quiet")]
    return [page.details(name, values) for name, values in sorted(latest.items())]
