# SPDX-License-Identifier: BSD-3-Clause
"""Recorded speech, noise and rooms of a folder with a manifest.csv."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.random import Generator

from voice_assist.audio.espeak import Int16
from voice_assist.audio.sound_file import read_sound
from voice_assist.errors import ManifestError
from voice_assist.text.csv_rows import csv_rows
from voice_assist.training.cache_key import keyed
from voice_assist.training.data.noise import Surroundings, build_rooms
from voice_assist.training.data.synthesis import TrainingClip, read_sounds, save_sounds
from voice_assist.training.data.texts import normalise_text

MANIFEST = "manifest.csv"
SPEECH_KINDS = ("speech", "positive")  # of rows; the others are "noise" and "rir"
_COLUMNS = ("path", "kind", "transcript", "speaker", "seconds", "source", "split")
_LONGEST = 36.0  # [s] of a file of speech


@dataclass(frozen=True)
class ManifestRow:
    """One line of the manifest."""

    path: Path
    kind: str
    transcript: str
    speaker: str
    seconds: float
    source: str
    split: str


def read_manifest(folder: Path) -> list[ManifestRow]:
    """Rows of folder/manifest.csv in file order; none where it is absent.

    Raises:
        ManifestError: It cannot be read, or a row of it has no path or no length.
    """
    path = folder / MANIFEST
    if not path.exists():
        return []
    return [_row(path, line, cells) for line, cells in csv_rows(path, *_COLUMNS)]


def training_sentences(rows: Sequence[ManifestRow]) -> list[str]:
    """Distinct transcripts of training sentences, for the synthetic voices."""
    said = {normalise_text(r.transcript) for r in rows if r.split == "train"}
    return sorted(text for text in said if len(text.split()) >= 4)


def speech_rows(
    rows: Sequence[ManifestRow], split: str, longest: float = _LONGEST
) -> list[ManifestRow]:
    """Speech of one split, as `load_speech` takes it."""
    return [
        row
        for row in rows
        if row.split == split
        and row.kind in SPEECH_KINDS
        and row.seconds <= longest
        and (row.transcript or split != "train")
    ]


def load_speech(
    rows: Sequence[ManifestRow], split: str, cache: Path, longest: float = _LONGEST
) -> list[TrainingClip]:
    """Speech of one split that has a transcript, in manifest order.

    Args:
        rows: Lines of the manifest.
        split: "train", "dev" or "false_accept_dev".
        cache: Folder for the decoded sound; read where that of these very files is there.
        longest: Longer files are left out [s].
    """
    wanted = speech_rows(rows, split, longest)
    if not wanted:
        return []
    path = keyed(cache / f"{split}.npz", stamped(wanted))
    if not path.exists():
        cache.mkdir(parents=True, exist_ok=True)
        with ThreadPoolExecutor(2) as pool:
            save_sounds(list(pool.map(lambda row: read_int16(row.path), wanted)), path)
    sounds = read_sounds(path)
    return [
        TrainingClip(sound, normalise_text(row.transcript), _kind(row), row.speaker or row.source)
        for row, sound in zip(wanted, sounds, strict=True)
    ]


def stamped(rows: Sequence[ManifestRow]) -> list[tuple[ManifestRow, int, int]]:
    """Rows with size [B] and time of change [ns] of their files, to tell others from these."""
    return [(row, *_stamp(row.path)) for row in rows]


def load_sounds(rows: Sequence[ManifestRow], kind: str) -> list[np.ndarray]:
    """Noise or room responses for training, float32, each of shape (n,)."""
    paths = [row.path for row in rows if row.kind == kind and row.split == "train"]
    return [read_int16(path).astype(np.float32) / 32768 for path in paths]


def load_surroundings(
    rows: Sequence[ManifestRow], rng: Generator, talkers: Sequence[Int16] = ()
) -> Surroundings:
    """Recorded noises and rooms with computed ones, and speech to make babble of."""
    rooms = build_rooms(load_sounds(rows, "rir"), rng)
    return Surroundings(load_sounds(rows, "noise"), rooms, talkers)


def read_int16(path: Path) -> np.ndarray:
    """Read any sound file as int16, 16 kHz mono.

    Raises:
        AudioError: The file cannot be read to its end.
    """
    return np.round(np.clip(read_sound(path), -1, 1) * 32767).astype(np.int16)


def _stamp(path: Path) -> tuple[int, int]:
    """Nothing of a file that is not there: who reads it says so."""
    try:
        found = path.stat()
    except OSError:
        return 0, 0
    return found.st_size, found.st_mtime_ns


def _kind(row: ManifestRow) -> str:
    words = len(row.transcript.split())
    return "sentence" if words > 2 else "word"


def _row(manifest: Path, line: int, cells: Sequence[str]) -> ManifestRow:
    path, kind, transcript, speaker, seconds, source, split = cells
    try:
        length = float(seconds)
    except ValueError as error:
        words = f"{manifest}: row {line}: seconds {seconds!r}, allowed: a number"
        raise ManifestError(words) from error
    if not path:
        raise ManifestError(f"{manifest}: row {line}: path '', allowed: a file in its folder")
    return ManifestRow(manifest.parent / path, kind, transcript, speaker, length, source, split)
