# SPDX-License-Identifier: BSD-3-Clause
"""Makes the report of one session: an HTML page and its figures as PNG files."""

from __future__ import annotations

import io
import math
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import matplotlib as mpl
import matplotlib.style
from matplotlib.backends.backend_agg import FigureCanvasAgg

from session_log.analysis import command_rows, rcm_while_moving, statistics, tension_statistics
from session_log.config import ReportConfig
from session_log.errors import OutputFailed
from session_log.extract import extract
from session_log.reader import SessionReader
from session_log.report import page, tables
from session_log.report.figures import FIGURES, Material, SessionFigure
from session_log.report.figures.rcm import micrometres
from session_log.report.style import NARROW, RC, WIDE, Layout

PAGE_NAME = "report.html"
COMMANDS_NOTE = "Decision and action: time after the end of speech."


@dataclass(frozen=True)
class Report:
    """What was written."""

    page: Path
    figures: list[Path]


def write_report(reader: SessionReader, folder: Path, config: ReportConfig) -> Report:
    """Read a session and write `report.html` and one PNG per figure.

    Args:
        reader: The recording, sound or not.
        folder: Where to write; made if it is not there.
        config: Settings of the report.

    Raises:
        OutputFailed: The folder cannot be written.
    """
    data = extract(reader, config)
    material = Material(data, command_rows(data, config), config)
    with mpl.style.context(RC):
        try:
            folder.mkdir(parents=True, exist_ok=True)
            images = {f.name: _image(f, material) for f in FIGURES if f.can_draw(material)}
            written = _write_figures(folder, material, images)
            target = folder / PAGE_NAME
            target.write_text(_page(reader, material, images), encoding="utf-8")
        except OSError as error:
            raise OutputFailed(folder, error) from error
    return Report(target, written)


def _write_figures(folder: Path, material: Material, images: dict[str, page.Image]) -> list[Path]:
    written = []
    for figure in (f for f in FIGURES if f.name in images):
        path = folder / f"{figure.name}.png"
        path.write_bytes(images[figure.name].wide)
        written.append(path)
        if material.config.vector:
            vector = path.with_suffix(".pdf")
            figure.draw(material, WIDE).savefig(vector)
            written.append(vector)
    return written


def _image(figure: SessionFigure, material: Material) -> page.Image:
    return page.Image(
        title=figure.title,
        caption=figure.caption(material),
        wide=_png(figure, material, WIDE),
        narrow=_png(figure, material, NARROW),
    )


def _png(figure: SessionFigure, material: Material, layout: Layout) -> bytes:
    drawn = figure.draw(material, layout)
    FigureCanvasAgg(drawn)
    buffer = io.BytesIO()
    drawn.savefig(buffer, format="png", dpi=material.config.resolution)
    return buffer.getvalue()


def _page(reader: SessionReader, material: Material, images: dict[str, page.Image]) -> str:
    parts = [_title(reader, material), *_warnings(material), page.facts(_facts(material))]
    for figure in FIGURES:
        parts.append(page.heading(figure.title))
        if figure.name in images:
            parts.append(page.figure(images[figure.name]))
        else:
            parts.append(page.paragraph(figure.lacking, "quiet"))
        if figure.name == "timeline":
            parts += [page.heading("Commands"), page.paragraph(COMMANDS_NOTE, "quiet")]
            parts.append(page.table(tables.commands_table(material)))
        if figure.name == "latency":
            parts += _latency_table(material)
    parts += [page.heading("Health"), _health(material)]
    parts += [page.heading("Recording"), page.table(tables.topics_table(material))]
    parts += [page.heading("Origin"), *_origin(material)]
    return page.page(f"Session {_name(reader)}", parts)


def _latency_table(material: Material) -> list[str]:
    has_spoken = any(row.heard for row in material.rows)
    return [page.table(tables.latency_table(material))] if has_spoken else []


def _name(reader: SessionReader) -> str:
    is_default = reader.path.name == "session.mcap"
    return reader.path.resolve().parent.name if is_default else reader.path.stem


def _title(reader: SessionReader, material: Material) -> str:
    survey = material.data.survey
    began = datetime.fromtimestamp(survey.start * 1e-9).astimezone() if survey.start else None
    words = began.strftime("%d %B %Y, %H:%M:%S %Z") if began else "no messages"
    length = f"{survey.duration:.1f} s, {survey.messages} messages"
    size = tables.size_words(survey.condition.size)
    return page.title_block(f"Session {_name(reader)}", f"{words} · {length} · {size}")


def _warnings(material: Material) -> list[str]:
    survey, words = material.data.survey, []
    condition = survey.condition
    if not condition.is_closed:
        words.append("The recorder did not close this file: it was killed, or is still running.")
    if condition.checksum == "wrong":
        words.append("The file was changed after it was written: its checksum is wrong.")
    if condition.damage:
        lost = sum(damage.length for damage in condition.damage)
        words.append(f"{lost} bytes in {len(condition.damage)} places cannot be read.")
    if survey.missing:
        words.append(f"{survey.missing} messages were received but are not in the file.")
    for name, loss in condition.latest("losses").items():
        words.append(f"Lost on {name}: {loss}.")
    for topic, count in material.data.undecodable.items():
        words.append(f"{count} messages of {topic} do not fit what the report expects.")
    return [page.paragraph(" ".join(words), "warn")] if words else []


def _facts(material: Material) -> dict[str, str]:
    spoken = [row for row in material.rows if row.heard]
    latency = statistics([row.action_latency for row in material.rows])
    rcm, pulled = rcm_while_moving(material.data), tension_statistics(material.data)
    facts = {
        "spoken commands": str(len(spoken)),
        "refused": str(sum(1 for row in material.rows if row.outcome == "refused")),
        "speech that did nothing": str(sum(1 for h in material.data.heard if not h.command)),
    }
    if math.isfinite(latency.mean):
        facts["end of speech to action, mean"] = f"{latency.mean:.2f} s"
    if rcm.count:
        facts["largest RCM error while moving"] = micrometres(rcm.largest)
    if pulled.count:
        facts["largest tension"] = f"{pulled.largest:.2f} N"
    return facts


def _health(material: Material) -> str:
    if not material.data.health:
        return page.paragraph("The recording holds no diagnostics.", "quiet")
    return page.table(tables.health_table(material))


def _origin(material: Material) -> list[str]:
    latest = dict(material.data.survey.condition.metadata)
    if not latest:
        return [page.paragraph("The recording holds no metadata.", "quiet")]
    return [page.details(name, values) for name, values in sorted(latest.items())]
