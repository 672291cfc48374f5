# SPDX-License-Identifier: BSD-3-Clause
"""The `listen` verb: what is heard, as it is heard, in the terminal or as lines."""

from __future__ import annotations

import threading
import time
from collections import deque
from contextlib import nullcontext
from dataclasses import dataclass, field

from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from voice_assist.assembly import make_pipeline, make_source
from voice_assist.audio.capture.input_check import SoundWatch
from voice_assist.audio.source import level_db
from voice_assist.cli.level_meter import QUIETEST_DB, level_bar
from voice_assist.config import VoiceConfig
from voice_assist.pipeline.pipeline import Event
from voice_assist.types import Frame, Lost, Mode, Partial, UtteranceDecision

_ROWS = 12  # decisions shown at once


@dataclass
class Screen:
    """What the terminal shows."""

    mode: Mode
    level: float = QUIETEST_DB  # [dB] of full scale
    partial: str = ""
    trouble: str = "opening the source"
    rows: deque[tuple[str, ...]] = field(default_factory=lambda: deque(maxlen=_ROWS))

    def show(self, event: Event) -> None:
        """Take over what the pipeline gave."""
        if isinstance(event, Partial):
            self.partial = event.text
        elif isinstance(event, Lost):
            self.rows.append(("", f"{event.samples} samples lost", "", "", "", ""))
        else:
            self.rows.append(row(event))

    def hear(self, frame: Frame) -> None:
        """Follow the level, which falls slowly."""
        self.level = max(level_db(frame.samples), self.level - 1.0, QUIETEST_DB)

    def note(self, trouble: str, mode: Mode) -> None:
        """Take over how the source is, and the mode."""
        self.trouble, self.mode = trouble, mode

    def __rich__(self) -> Group:
        """All of it, for rich."""
        style = "bold green" if self.mode is Mode.ACTIVE else "bold yellow"
        head = Text.assemble(
            (f" {self.mode.value} ", style),
            "  ",
            *level_bar(self.level),
            (f" {self.level:4.0f} dB", "dim"),
        )
        heard = Text(f" {self.partial or '...'}", style="cyan" if self.partial else "dim")
        trouble = [Text(self.trouble, style="bold red")] if self.trouble else []
        return Group(head, heard, *trouble, _table(self.rows))


class Lines(Screen):
    """The same for an output that is no terminal: each piece of news is a line, as it comes."""

    def show(self, event: Event) -> None:
        """Print what the pipeline gave, but for the text of speech that goes on."""
        if not isinstance(event, Partial):
            super().show(event)
            print("  ".join(filter(None, self.rows[-1])), flush=True)

    def note(self, trouble: str, mode: Mode) -> None:
        """Print them where they changed."""
        if trouble != self.trouble:
            print(f"trouble: {trouble}" if trouble else "sound comes in", flush=True)
        if mode is not self.mode:
            print(f"mode: {mode.value}", flush=True)
        super().note(trouble, mode)


def row(decision: UtteranceDecision) -> tuple[str, ...]:
    """One line of the table: heard, taken for, WER, confidence, latency, reason."""
    nearest, rejection = decision.nearest_command, decision.rejection
    wer = decision.outcome.wer.get(nearest)
    return (
        decision.hypothesis.text,
        nearest if decision.command else f"({nearest})" if nearest else "",
        "" if wer is None else f"{wer:.2f}",
        f"{decision.confidence:.2f}",
        f"{1e3 * (decision.decided - decision.speech_end):.0f} ms",
        "" if rejection is None else rejection.words,
    )


def listen(config: VoiceConfig, mode: Mode) -> None:
    """Show what is heard until Ctrl-C or the end of the recording.

    Raises:
        VoiceError: Model or recording cannot be used.
    """
    console = Console()
    screen = Screen(mode) if console.is_terminal else Lines(mode)
    stop = threading.Event()

    def report(trouble: str) -> None:
        screen.note(trouble, screen.mode)

    with make_source(config.audio, time.time, stop.wait, report) as source:
        console.print("loading the models ...", style="dim")
        pipeline = make_pipeline(config, time.time)
        pipeline.set_mode(mode, "start")
        console.print("Ctrl-C ends. A spoken stop is no emergency stop.", style="dim")
        watch = SoundWatch(source, config.audio.deaf_after)
        live = Live(screen, console=console, refresh_per_second=12)
        with live if console.is_terminal else nullcontext():
            for frame in source:
                screen.hear(frame)
                for event in pipeline(frame):
                    screen.show(event)
                screen.note(watch(frame) or source.remark, pipeline.state.mode)


def _table(rows: deque[tuple[str, ...]]) -> Table:
    table = Table(expand=True, box=None, header_style="dim")
    for name in ("heard", "taken for (nearest)", "WER", "confidence", "latency", "why not"):
        table.add_column(name)
    for cells in rows:
        table.add_row(*cells, style="dim" if cells[-1] else "bold")
    return table
