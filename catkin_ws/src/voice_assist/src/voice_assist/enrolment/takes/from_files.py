# SPDX-License-Identifier: BSD-3-Clause
"""Takes from a folder of recordings that exist already.

Either a file `takes.csv` with the columns `path` and `transcript` says what is in which, or the
names do: `pull_more-3.wav` is a take of "pull more", `talk-1.wav` is talk, `room-1.wav` the room.
What stands behind the first hyphen says nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from voice_assist.audio.sound_file import read_sound
from voice_assist.enrolment.takes.script import RecordedTake
from voice_assist.errors import AudioError, ManifestError
from voice_assist.profile.manifest import COMMAND, ROOM, TALK
from voice_assist.text.csv_rows import csv_rows
from voice_assist.text.normalize import normalize, with_same_words
from voice_assist.types import RATE

LIST = "takes.csv"
_ENDINGS = (".wav", ".flac", ".ogg", ".opus", ".mp3")
_LONGEST = 600.0  # [s] of one recording of talk


@dataclass(frozen=True)
class Recording:
    """One file, and what is in it."""

    path: Path
    kind: str  # COMMAND, TALK or ROOM
    phrase: str  # empty where it is no command


def find_recordings(
    folder: Path, phrases: Sequence[str], on_left_out: Callable[[str], None] = lambda _: None
) -> list[Recording]:
    """What a folder holds, by its list or by the names of its files.

    Args:
        folder: Of recordings.
        phrases: Of all commands.
        on_left_out: Called with each file whose name makes it no recording, and why.

    Raises:
        ManifestError: The folder or its list cannot be used, or a file has no known name.
    """
    if not folder.is_dir():
        raise ManifestError(f"{folder}: no such folder")
    listed = folder / LIST
    pairs = list(_listed(listed) if listed.is_file() else _named(folder, on_left_out))
    if not pairs:
        allowed = f"allowed: names such as pull_more-3.wav or talk-1.wav, or a list {LIST}"
        raise ManifestError(f"{folder}: no recordings in it, {allowed}")
    return [_recording(path, said, phrases) for path, said in pairs]


def read_recordings(recordings: Iterable[Recording]) -> Iterator[RecordedTake]:
    """The recordings with their sound, each read when it is asked for.

    Raises:
        ManifestError: One cannot be read, or is too long.
    """
    for recording in recordings:
        try:
            samples = read_sound(recording.path)
        except AudioError as error:
            raise ManifestError(str(error)) from error
        if len(samples) > _LONGEST * RATE:
            found = f"{len(samples) / RATE:.0f} s, allowed: up to {_LONGEST:.0f}"
            raise ManifestError(f"{recording.path}: {found}")
        yield RecordedTake(recording.path.name, recording.kind, recording.phrase, samples)


def _listed(path: Path) -> Iterator[tuple[Path, str]]:
    for _, (name, transcript) in csv_rows(path, "path", "transcript"):
        yield path.parent / name.strip(), transcript.strip() or TALK


def _named(folder: Path, on_left_out: Callable[[str], None]) -> Iterator[tuple[Path, str]]:
    for path in sorted(folder.iterdir()):
        said = path.stem.partition("-")[0].replace("_", " ")
        if not path.is_file():
            on_left_out(f"{path.name} is left out: it is no file")
        elif path.suffix.lower() not in _ENDINGS:
            allowed = f"allowed: {', '.join(_ENDINGS)}"
            on_left_out(f"{path.name} is left out: its ending is {path.suffix!r}, {allowed}")
        elif not said:
            on_left_out(f"{path.name} is left out: no command stands in front of its hyphen")
        else:
            yield path, said


def _recording(path: Path, said: str, phrases: Sequence[str]) -> Recording:
    words = " ".join(normalize(said))
    if words in (TALK, ROOM):
        return Recording(path, words, "")
    phrase = with_same_words(said, phrases)
    if not phrase:
        allowed = ", ".join((*phrases, TALK, ROOM))
        raise ManifestError(f"{path.name}: {said!r} is no command, allowed: {allowed}")
    return Recording(path, COMMAND, phrase)
