# SPDX-License-Identifier: BSD-3-Clause
"""The tables of a report as rows of words; the page only has to set them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from session_log.analysis import (
    CommandRow,
    Statistics,
    decision_by_command,
    latency_by_command,
    statistics,
)
from session_log.report.figures import Material
from session_log.session_data import Heard

NONE = "–"
LEVELS = {0: "ok", 1: "warning", 2: "error", 3: "stale"}


@dataclass(frozen=True)
class TextTable:
    """Column titles and rows; `marks` holds a word for rows that stand out."""

    columns: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    marks: tuple[str, ...] = ()


def commands_table(material: Material) -> TextTable:
    """List every utterance and every command in order of time."""
    columns = ("time", "heard", "command", "WER", "outcome", "decision", "action", "why")
    silent = [h for h in material.data.heard if not h.command]
    entries = [(row.time, _command_row(row), _mark(row)) for row in material.rows]
    entries += [(h.decision, _nothing_row(h), "nothing") for h in silent]
    entries.sort(key=lambda entry: entry[0])
    return TextTable(columns, [e[1] for e in entries], tuple(e[2] for e in entries))


def latency_table(material: Material) -> TextTable:
    """Set our latency beside the paper's table 1, by command."""
    paper = {entry.command: entry.latency for entry in material.config.paper_latency}
    acted, decided = latency_by_command(material.rows), decision_by_command(material.rows)
    columns = ("command", "n", "decision, mean", "action, mean", "action, largest", "paper, mean")
    rows = []
    for command in dict.fromkeys([*paper, *acted, *decided]):
        ours = acted.get(command)
        rows.append(
            (
                command,
                str(ours.count if ours else 0),
                _seconds(decided.get(command)),
                _seconds(ours),
                seconds(ours.largest) if ours else NONE,
                seconds(paper.get(command, math.nan)),
            )
        )
    ours = statistics([row.action_latency for row in material.rows])
    decision = statistics([row.decision_latency for row in material.rows])
    mean = sum(paper.values()) / len(paper) if paper else math.nan
    total = ("all", str(ours.count), _seconds(decision), _seconds(ours), seconds(ours.largest))
    rows.append((*total, seconds(mean)))
    return TextTable(columns, rows, ("",) * (len(rows) - 1) + ("total",))


def topics_table(material: Material) -> TextTable:
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
        for name, topic in sorted(material.data.survey.topics.items())
    ]
    return TextTable(columns, rows, tuple("bad" if r[-1] != "0" else "" for r in rows))


def health_table(material: Material) -> TextTable:
    """List what the nodes said in diagnostics: the worst, and the last."""
    rows, marks = [], []
    for health in material.data.health:
        worst = LEVELS.get(health.worst, str(health.worst))
        when = f" ({health.worst_time:.1f} s)" if health.worst else ""
        values = ", ".join(f"{key} {value}" for key, value in health.values.items())
        words = f"{worst}: {health.worst_message}{when}"
        rows.append((health.name, words, health.last_message, values))
        marks.append("bad" if health.worst == 2 else "warning" if health.worst else "")
    return TextTable(("part", "worst", "last", "last values"), rows, tuple(marks))


def seconds(value: float) -> str:
    """Write a time in seconds; a dash for none."""
    return f"{value:.2f}\u00a0s" if math.isfinite(value) else NONE


def size_words(size: float) -> str:
    """Write a size in bytes, kB, MB or GB."""
    for unit in ("B", "kB", "MB"):
        if size < 1000:
            return f"{size:.0f} {unit}" if unit == "B" else f"{size:.1f} {unit}"
        size /= 1000
    return f"{size:.2f} GB"


def _seconds(values: Statistics | None) -> str:
    return seconds(values.mean) if values else NONE


def _command_row(row: CommandRow) -> tuple[str, ...]:
    heard = row.heard
    spoken = (f"“{heard.transcript}”", _wer(heard)) if heard else ("by\u00a0hand", NONE)
    decision, action = seconds(row.decision_latency), seconds(row.action_latency)
    time = f"{row.time:.1f}\u00a0s"
    return (time, spoken[0], row.command, spoken[1], row.outcome, decision, action, row.message)


def _nothing_row(heard: Heard) -> tuple[str, ...]:
    decision = seconds(heard.decision - heard.speech_end)
    why = heard.reason + (f"; nearest: {heard.nearest}" if heard.nearest else "")
    words = f"“{heard.transcript}”"
    return (
        f"{heard.decision:.1f}\u00a0s",
        words,
        NONE,
        _wer(heard),
        "nothing",
        decision,
        NONE,
        why,
    )


def _wer(heard: Heard) -> str:
    return f"{heard.wer * 100:.0f}\u00a0%" if math.isfinite(heard.wer) else NONE


def _mark(row: CommandRow) -> str:
    return {"refused": "bad", "no answer": "warning"}.get(row.outcome, "")
