# SPDX-License-Identifier: BSD-3-Clause
"""The results on the screen and as a file in the form of the bench's."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from paper.judging.recording import VERDICT
from paper.judging.results import CommandResult, VoiceResult, row
from paper.play.demonstration import Shown
from paper.play.plan import COMMANDS
from support.figures import Figure, machine


def write(figures: Sequence[Figure], told: Sequence[VoiceResult], path: Path) -> None:
    """Write figures with machine, date, commit and voices."""
    voices = [asdict(t.voice) for t in told]
    listed = [{**asdict(f), "met": f.is_met} for f in figures]
    data = {"machine": machine(), "voices": voices, "figures": listed}
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")


def show(told: Sequence[VoiceResult], paper: Mapping[str, float], console: Console) -> None:
    """Print one table by command over all voices, and one by voice."""
    table = Table(title=f"Synthetic voices: {len(told)}; times in s from the end of the sound")
    table.add_column("command", no_wrap=True)
    for column in ("said", "right", "refused", "decided", "acts", "p95", "paper"):
        table.add_column(column, justify="right", no_wrap=True)
    table.add_column("instead")
    for command in COMMANDS:
        table.add_row(*_cells(row(command, told), paper))
    console.print(table)
    voices = Table()
    for column in ("voice", "accent", "native", "commands right", "talk taken"):
        voices.add_column(column)
    for t in told:
        voices.add_row(*_voice_cells(t))
    console.print(voices)


def show_tissue(states: Sequence[Shown], console: Console) -> None:
    """Print how the tissue was held after each command of the demonstration."""
    table = Table(title="Triangulation demonstration: the tissue after each command")
    for column in ("command", "tissue", "numbers"):
        table.add_column(column)
    for state in states:
        numbers = ", ".join(f"{k} {v}" for k, v in state.tissue.items() if k != VERDICT)
        table.add_row(state.command, state.tissue[VERDICT], escape(numbers))
    console.print(table)


def _cells(r: CommandResult, paper: Mapping[str, float]) -> list[str]:
    others = ", ".join(f"{n} x {what}" for what, n in r.others.most_common())
    theirs = f"{paper[r.command]:.2f}" if r.command in paper else ""
    return [
        *(r.command, str(r.said), str(r.correct), str(r.refused)),
        *(_mean(r.decided), _mean(r.acted), _p95(r.acted), theirs, others),
    ]


def _voice_cells(t: VoiceResult) -> list[str]:
    said = [o for o in t.repetitions if o.command]
    talk = [o for o in t.repetitions if not o.command]
    return [
        *(t.voice.name, t.voice.accent, "yes" if t.voice.is_native else "no"),
        f"{sum(o.is_correct for o in said)} of {len(said)}",
        f"{sum(not o.is_correct for o in talk)} of {len(talk)}",
    ]


def _mean(values: Sequence[float]) -> str:
    return f"{np.mean(values):.2f}" if values else ""


def _p95(values: Sequence[float]) -> str:
    return f"{np.percentile(values, 95):.2f}" if values else ""
