# SPDX-License-Identifier: BSD-3-Clause
"""The tables of one session."""

from __future__ import annotations

import math
from collections.abc import Sequence

from session_log.report.figures import SessionMaterial
from session_log.report.notes import Note
from session_log.report.session.analysis import FAILED, CommandRow
from session_log.report.session.session_data import ERROR, STALE, RecordedUtterance
from session_log.report.session.stops import UNREPORTED, RecordedStop
from session_log.report.tables.text_table import NONE, TextTable, seconds, size_words

LEVELS = {0: "ok", 1: "warning", ERROR: "error", STALE: "stale"}


def commands_table(material: SessionMaterial) -> TextTable:
    """List every utterance and every command in order of time."""
    columns = ("time", "heard", "command", "WER", "outcome", "decision", "action", "why")
    sounds = material.data.sounds
    silent = [h for h in material.data.heard if not h.command]
    entries = [(row.time, _command_row(row), _mark(row), row.heard) for row in material.rows]
    entries += [(h.decision, _nothing_row(h), "nothing", h) for h in silent]
    entries.sort(key=lambda entry: entry[0])
    return TextTable(
        columns,
        [cells for _, cells, _, _ in entries],
        tuple(mark for _, _, mark, _ in entries),
        times=tuple(time for time, _, _, _ in entries),
        sounds=tuple(sounds.get(heard, b"") if heard else b"" for _, _, _, heard in entries),
        transcripts=tuple(heard.transcript if heard else "" for _, _, _, heard in entries),
    )


def notes_table(notes: Sequence[Note]) -> TextTable:
    """List the notes in their order."""
    rows = [(NONE if note.time is None else _moment(note.time), note.words) for note in notes]
    return TextTable(("time", "note"), rows, is_compact=True)


def reasons_table(material: SessionMaterial, outcome: str) -> TextTable:
    """List the commands of an outcome, by whom each was asked for, and the words of the answer."""
    rows = [
        (_moment(row.time), row.command, _asked(row), row.message or "no reason given")
        for row in material.rows
        if row.outcome == outcome
    ]
    return TextTable(("time", "command", "asked for by", "why"), rows)


def stops_table(found: Sequence[RecordedStop]) -> TextTable:
    """List everything that stopped the robot, with its cause."""
    rows = [
        (
            _moment(stop.time),
            stop.cause or UNREPORTED,
            stop.command or NONE,
            seconds(stop.at_rest),
            "until “hey robot”" if stop.is_latched else "no",
        )
        for stop in found
    ]
    marks = tuple("bad" if stop.cause in ("", UNREPORTED) else "" for stop in found)
    return TextTable(("time", "cause", "in execution", "at rest after", "latched"), rows, marks)


def topics_table(material: SessionMaterial) -> TextTable:
    """List the recorded topics."""
    columns = ("topic", "type", "messages", "rate", "size", "missing")
    rows = [
        (
            name,
            topic.datatype,
            str(topic.messages),
            f"{topic.rate:.1f}\u00a0Hz" if topic.messages > 1 else NONE,
            size_words(topic.size),
            str(topic.missing),
        )
        for name, topic in sorted(material.data.recording.topics.items())
    ]
    return TextTable(columns, rows, tuple("bad" if r[-1] != "0" else "" for r in rows))


def health_table(material: SessionMaterial) -> TextTable:
    """List what the nodes said in diagnostics: the worst, and the last."""
    rows, marks = [], []
    for health in material.data.health:
        worst = LEVELS.get(health.worst, str(health.worst))
        when = f" ({health.worst_time:.1f} s)" if health.worst else ""
        values = ", ".join(f"{key} {value}" for key, value in health.values.items())
        words = f"{worst}: {health.worst_message}{when}"
        rows.append((health.name, words, health.last_message, values))
        marks.append("bad" if health.worst in (ERROR, STALE) else "warning" if health.worst else "")
    return TextTable(("part", "worst", "last", "last values"), rows, tuple(marks))


def _command_row(row: CommandRow) -> tuple[str, ...]:
    wer = _wer(row.heard) if row.heard else NONE
    decision, action = seconds(row.decision_latency), seconds(row.action_latency)
    about = (_asked(row), row.command, wer, row.outcome, decision, action, row.message)
    return (_moment(row.time), *about)


def _moment(time: float) -> str:
    return f"{time:.1f}\u00a0s"


def _asked(row: CommandRow) -> str:
    """The words that were heard; else the node that asked, or a hand where it is unknown."""
    return f"“{row.heard.transcript}”" if row.heard else f"by\u00a0{row.given_by}"


def _nothing_row(heard: RecordedUtterance) -> tuple[str, ...]:
    time, decision = _moment(heard.decision), seconds(heard.decision - heard.speech_end)
    why = heard.reason + (f"; nearest: {heard.nearest_command}" if heard.nearest_command else "")
    return (time, f"“{heard.transcript}”", NONE, _wer(heard), "nothing", decision, NONE, why)


def _wer(heard: RecordedUtterance) -> str:
    return f"{heard.wer * 100:.0f}\u00a0%" if math.isfinite(heard.wer) else NONE


def _mark(row: CommandRow) -> str:
    return {"refused": "bad", FAILED: "bad", "no answer": "warning"}.get(row.outcome, "")
