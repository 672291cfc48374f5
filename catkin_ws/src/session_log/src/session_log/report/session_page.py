# SPDX-License-Identifier: BSD-3-Clause
"""The page of one session: its parts, in their order."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from typing import Any

from session_log.mcap_file.summary import RecordingSummary
from session_log.report.figures import POOL_FIGURES, SESSION_FIGURES, ReportFigure, SessionMaterial
from session_log.report.figures.rcm import why_no_error
from session_log.report.notes import Note
from session_log.report.page import Image, Section, page, table_section
from session_log.report.pool.pool import InputCounts, Pool
from session_log.report.sections import (
    FAILURES,
    OF_THEM_REFUSED,
    figure_section,
    inputs_section,
    large_facts,
)
from session_log.report.session.analysis import FAILED, VOICE
from session_log.report.session.namespaces import namespaces_of
from session_log.report.session.stops import stops
from session_log.report.tables import session_tables
from session_log.report.tables.text_table import duration_words, size_words
from session_log.report.zoom import zoom_data

DAY = 86_400.0  # [s]
LOSS_SHARE = 1e-3  # of a topic's messages: less is a note, not a warning
COMMANDS_NOTE = "Decision and action: time after the end of speech."
BELOW_COMMANDS = (
    "accuracy",
    "confusion",
    "latency",
    "rcm_error",
    "tension",
    "scene",
    "joints",
    "loop_timing",
)
_ALL_FIGURES: tuple[ReportFigure[Any], ...] = (*SESSION_FIGURES, *POOL_FIGURES)
_FIGURES = {figure.name: figure for figure in _ALL_FIGURES}


def session_page(
    material: SessionMaterial,
    name: str,
    pool: Pool,
    images: Mapping[str, Image],
    notes: Sequence[Note],
) -> str:
    """Set the page.

    Args:
        material: Of the session.
        name: Of the session.
        pool: Of this session alone.
        images: The figures that could be drawn.
        notes: Of people.
    """
    spoken = pool.inputs.get(VOICE, InputCounts())
    return page(
        f"Session {name}",
        _subtitle(material.data.recording),
        " ".join(_warnings(material)),
        large_facts(pool, {"spoken commands": spoken.given, OF_THEM_REFUSED: spoken.refused}),
        _sections(material, pool, images, notes),
    )


def _sections(
    material: SessionMaterial, pool: Pool, images: Mapping[str, Image], notes: Sequence[Note]
) -> Iterator[Section]:
    data = material.data
    timeline = figure_section(_FIGURES["timeline"], images, pool)
    yield replace(timeline, zoom=zoom_data(material, notes)) if timeline.image else timeline
    if notes:
        yield Section("Notes", table=session_tables.notes_table(notes))
    yield Section("Commands", COMMANDS_NOTE, table=session_tables.commands_table(material))
    found = session_tables.stops_table(stops(data.events, data.states))
    yield table_section("What stopped the robot, and why", found, "Nothing stopped the robot.")
    refused = session_tables.reasons_table(material, "refused")
    yield table_section("What was refused, and why", refused, "Nothing was refused.")
    if (failed := session_tables.reasons_table(material, FAILED)).rows:
        yield Section(FAILURES, table=failed)
    if len(pool.inputs) > 1:
        yield inputs_section(pool)
    for name in BELOW_COMMANDS:
        if name != "confusion" or name in images:  # else the accuracy's place says why
            section = figure_section(_FIGURES[name], images, pool)
            is_unknown = name == "rcm_error" and not section.image
            yield replace(section, note=why_no_error(material)) if is_unknown else section
    health = session_tables.health_table(material)
    health_part = table_section("Health", health, "The recording holds no diagnostics.")
    yield replace(health_part, is_folded=True)
    few = " ".join(_losses(data.recording)[1])
    yield Section("Recording", few, table=session_tables.topics_table(material), is_folded=True)
    metadata = dict(sorted(dict(data.recording.condition.metadata).items()))  # the latest of each
    nothing = "" if metadata else "The recording holds no metadata."
    yield Section("Origin", nothing, details=metadata, is_folded=True)


def _subtitle(recording: RecordingSummary) -> str:
    began = datetime.fromtimestamp(recording.start * 1e-9).astimezone() if recording.start else None
    words = began.strftime("%d %B %Y, %H:%M:%S %Z") if began else "no messages"
    extent = f"{recording.duration:.1f} s, {recording.messages} messages"
    return f"{words} · {extent} · {size_words(recording.condition.size)}"


def _losses(recording: RecordingSummary) -> tuple[list[str], list[str]]:
    """What was lost before the recorder: what is worth a warning, and a few messages of many."""
    warned: list[str] = []
    noted: list[str] = []
    for name, loss in recording.losses.items():
        lost = sum(map(int, re.findall(r"\d+", loss)))
        topic = recording.topics.get(name.split(" ", 1)[0])
        of = f" of {topic.messages + lost} messages" if topic else ""
        is_little = topic is not None and lost < LOSS_SHARE * topic.messages
        (noted if is_little else warned).append(f"Lost on {name}: {loss}{of}.")
    return warned, noted


def _warnings(material: SessionMaterial) -> Iterator[str]:
    recording, condition = material.data.recording, material.data.recording.condition
    if not condition.is_closed:
        yield "The recorder did not close this file: it was killed, or is still running."
    if condition.checksum == "wrong":
        yield "The file was changed after it was written: its checksum is wrong."
    if condition.damage:
        lost = sum(damage.length for damage in condition.damage)
        yield f"{lost} bytes in {len(condition.damage)} places cannot be read."
    for cut in recording.cuts:
        yield f"{cut[0].upper()}{cut[1:]}."
    if recording.missing:
        yield f"{recording.missing} messages were received but are not in the file."
    for step in recording.clock_steps:
        words, is_back = str(step), step.after < step.before
        yield f"{words[0].upper()}{words[1:]}{': times after it are wrong' if is_back else ''}."
    if lags := material.data.clock_lags:
        yield f"{_clock_words(lags)}: where it is, their times are those of arrival."
    if offsets := material.data.clock_offsets:
        yield f"{_clock_words(offsets)}: their times, and latencies, are off by as much."
    topics = vars(material.config.topics)
    if namespaces := namespaces_of(topics.values(), recording.topics):
        where = " and ".join(namespaces)
        yield f"Topics of the report lie in {where}, where it does not look: name them (--config)."
    if count := material.data.other_joints:
        yield f"{count} samples of {topics['joint_states']} are left out: they have other joints."
    yield from _losses(recording)[0]
    for topic, count in material.data.undecodable.items():
        yield f"{count} messages of {topic} do not fit what the report expects."
    for what in sorted(material.data.missing_fields):
        yield f"Left out: {what}."


def _clock_words(lags: Mapping[str, float]) -> str:
    """Topics that another clock than the recorder's stamped, and how far that is off at most."""
    first, *others = sorted(lags)
    topics = f"{first} and {len(others)} more" if others else first
    lag = max(map(abs, lags.values()))
    apart = duration_words(lag) if lag < DAY else "more than a day"
    return f"The clock that stamped {topics} is {apart} off the recorder's"
