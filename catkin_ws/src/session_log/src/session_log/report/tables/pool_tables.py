# SPDX-License-Identifier: BSD-3-Clause
"""The tables that one session and many have in common: recognition, latency, refusals, motion."""

from __future__ import annotations

import math
from collections.abc import Mapping

from session_log.report.bounds import Bounded, proportion, quantile
from session_log.report.pool.pool import Pool
from session_log.report.session.analysis import VOICE
from session_log.report.session.trials import NO_COMMAND, NOT_SAID, NOTHING, OTHER
from session_log.report.tables.text_table import (
    NONE,
    TextTable,
    bounded,
    length,
    newtons,
    percent,
    seconds,
)


def accuracy_table(pool: Pool) -> TextTable:
    """Share of phrases that were taken as they were meant, by command."""
    columns = ("meant", "said", "right", "share", "95 % confidence")
    commands = [c for c in pool.commands if pool.accuracy(c).meant]
    entries = [(c, pool.accuracy(c)) for c in commands]
    entries.append(("all commands", pool.accuracy()))
    if pool.accuracy(NO_COMMAND).meant:
        entries.append((NO_COMMAND, pool.accuracy(NO_COMMAND)))
    rows = [
        (name, str(total), str(hits), percent(share.value), _interval(share) if total else NONE)
        for name, (hits, total, share) in entries
    ]
    marks = tuple("total" if name == "all commands" else "" for name, _ in entries)
    return TextTable(columns, rows, marks, numbers=(1, 2, 3, 4), is_compact=True)


def confusion_counts(pool: Pool) -> tuple[list[str], list[str], list[list[int]]]:
    """What was meant (rows), what it was taken for (columns), and how often."""
    meant = {pair[0] for pair in pool.confusions}
    taken = {pair[1] for pair in pool.confusions}
    commands = [c for c in pool.commands if c in meant | taken]
    rows = [c for c in [*commands, NO_COMMAND, NOT_SAID] if c in meant]
    columns = [*commands, OTHER, NOTHING]
    counts = [[pool.confusions[row, column] for column in columns] for row in rows]
    return rows, columns, counts


def confusion_table(pool: Pool) -> TextTable:
    """What was meant against what it was taken for."""
    rows, columns, counts = confusion_counts(pool)
    cells = [
        (row, *(str(n) if n else NONE for n in numbers))
        for row, numbers in zip(rows, counts, strict=True)
    ]
    return TextTable(("meant", *columns), cells, numbers=tuple(range(1, len(columns) + 1)))


def latency_table(pool: Pool) -> TextTable:
    """Set our latency beside the paper's table 1, by command."""
    paper = {entry.command: entry.latency for entry in pool.config.paper.latency}
    columns = (
        "command",
        "n",
        "decision, median [s]",
        "action, mean [s]",
        "action, median [s]",
        "action, 95th percentile [s]",
        "paper, mean [s]",
    )
    rows = [_latency_row(pool, c, paper.get(c, math.nan)) for c in pool.commands]
    mean = sum(paper.values()) / len(paper) if paper else math.nan
    rows = [row for row in rows if row[1] != "0" or row[0] in paper]
    rows.append(_latency_row(pool, "", mean))
    marks = ("",) * (len(rows) - 1) + ("total",)
    return TextTable(columns, rows, marks, numbers=tuple(range(1, 7)))


def reasons_table(counts: Mapping[tuple[str, str], int]) -> TextTable:
    """How often which command was refused or failed, and why.

    Args:
        counts: By command and reason.
    """
    counted = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    rows = [(command, reason, str(count)) for (command, reason), count in counted]
    return TextTable(("command", "why", "times"), rows, numbers=(2,))


def inputs_table(pool: Pool) -> TextTable:
    """Voice, pedals and hands beside each other; what no session knows is a dash."""
    columns = (
        "given by",
        "commands",
        "refused",
        "taken for another",
        "action, median [s]",
        "action, 95th percentile [s]",
    )
    rows = []
    for name, counts in sorted(pool.inputs.items(), key=lambda item: (item[0] != VOICE, item)):
        wrong, meant = pool.taken_for_another() if name == VOICE else (0, 0)
        rows.append(
            (
                name,
                str(counts.given),
                _share(counts.refused, counts.given),
                _share(wrong, meant) if meant else NONE,
                bounded(quantile(counts.reactions, 0.5)),
                bounded(quantile(counts.reactions, 0.95)),
            )
        )
    return TextTable(columns, rows, numbers=(1, 2, 3, 4, 5))


def motion_table(pool: Pool) -> TextTable:
    """RCM error, tension and what they are held against."""
    limit = pool.config.rcm_limit
    rows = []
    for source, error, above in (
        ("by the controller", pool.rcm, pool.rcm_above),
        ("from joint states", pool.rcm_joints, pool.rcm_joints_above),
    ):
        if error.count:
            name = f"RCM error while moving, {source}"
            largest = length(error.largest)
            beyond = f"{above} of {error.count} samples above {length(limit)}"
            rows.append((name, length(error.rms), largest, beyond))
    largest_tensions = (
        ("tension", pool.tension),
        ("tension with a target set", pool.tension_with_target),
    )
    rows += [(n, NONE, newtons(t), NONE) for n, t in largest_tensions if math.isfinite(t)]
    if pool.tension_error.count:
        error, name = pool.tension_error, "distance of the tension from its target at rest"
        samples = f"{error.count} samples"
        rows.append((name, newtons(error.rms), newtons(error.largest), samples))
    return TextTable(("measure", "RMS", "largest", "of"), rows, numbers=(1, 2))


def _latency_row(pool: Pool, command: str, paper: float) -> tuple[str, ...]:
    times = pool.latencies(command)
    decision, action = quantile(times.decision, 0.5), times.action
    mean = sum(action) / len(action) if action else math.nan
    return (
        command or "all",
        str(len(action)),
        _plain(decision.value),
        _plain(mean),
        bounded(quantile(action, 0.5)),
        bounded(quantile(action, 0.95)),
        _plain(paper),
    )


def _share(hits: int, trials: int) -> str:
    """A share with its exact bounds."""
    return f"{hits} ({_interval(proportion(hits, trials))})"


def _interval(share: Bounded) -> str:
    return f"{share.low * 100:.1f} to {share.high * 100:.1f}\u00a0%"


def _plain(value: float) -> str:
    return seconds(value).removesuffix("\u00a0s")
