# SPDX-License-Identifier: BSD-3-Clause
"""The `alarms` verb: all alarms to be seen, heard and written to files, without ROS."""

from __future__ import annotations

import time
from pathlib import Path

from rich.console import Console
from rich.text import Text

from typed_config import load_file
from voice_assist.alarms.appearance import APPEARANCES, headline
from voice_assist.alarms.catalogue import ENTRIES, Entry, markdown, sounds_of
from voice_assist.alarms.sound_output import ProgramOutput, write_sounds
from voice_assist.alarms.types import Earcon
from voice_assist.config.alarms import FILE, AlarmsConfig
from voice_assist.errors import AudioError

ALL = "all"
_PAUSE = 1.0  # [s] between two sounds


def show_alarms(
    folder: Path, play: str | None, write: Path | None, *, is_markdown: bool = False
) -> None:
    """Print every alarm; play or write the sounds where asked.

    Args:
        folder: Of the settings.
        play: Name of a sound, or "all"; None: none is played.
        write: Folder for WAV files, made if it is not there; None: none are written.
        is_markdown: Print the tables of docs/reference/alarms.md instead.

    Raises:
        AudioError: The sound cannot be played or written, or is asked for beside the tables.
    """
    if is_markdown:
        if play is not None or write is not None:
            raise AudioError("--markdown prints tables alone: leave out --play and --write-wav")
        print(markdown())
        return
    config, console = load_file(AlarmsConfig, folder / FILE.name), Console()
    if write is not None:
        _write(write, config, console)
    if play is not None:
        _play(play, config, console)
    if play is None and write is None:
        for entry in ENTRIES:
            _print(entry, console)
        console.print(
            "--play lets you hear them; how often each repeats is in alarms.yaml", style="dim"
        )


def names() -> tuple[str, ...]:
    """What can be played."""
    return (ALL, *(earcon.value for earcon in Earcon))


def _write(folder: Path, config: AlarmsConfig, console: Console) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        paths = write_sounds(folder, config.sound.volume_db)
    except FileExistsError as error:
        raise AudioError(f"{folder}: cannot be written, it is a file and no folder") from error
    except (OSError, RuntimeError) as error:  # libsndfile's errors are RuntimeErrors
        why = getattr(error, "strerror", None) or error
        raise AudioError(f"{folder}: cannot be written ({why})") from error
    for path in paths:
        console.print(str(path), soft_wrap=True, highlight=False)


def _play(wanted: str, config: AlarmsConfig, console: Console) -> None:
    chosen = [e for e in ENTRIES if wanted in (ALL, e.earcon.value)]
    with ProgramOutput(config.sound) as output:
        for number, entry in enumerate(chosen):
            if number:
                time.sleep(_PAUSE)
            _print(entry, console)
            output.play(entry.earcon, lambda: False)


def _print(entry: Entry, console: Console) -> None:
    shown = APPEARANCES[entry.example.priority]
    console.print(Text(f" {headline(entry.example)} ", style=shown.style), f"({shown.colour})")
    console.print(f"  name:  {entry.earcon.value}: {sounds_of(entry.earcon)}", highlight=False)
    console.print(f"  means: {entry.meaning}", highlight=False)
    console.print(f"  why:   {entry.example.cause}", highlight=False)
    console.print(f"  next:  {entry.example.next_step}", highlight=False)
