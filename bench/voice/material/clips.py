# SPDX-License-Identifier: BSD-3-Clause
"""Labelled sound to measure on: held-out synthetic voices, and people where present."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import soundfile

from bench.common.resumable import CACHE
from support.figures import ROOT
from support.theatre_sound import theatre_noise
from voice_assist.training.data.human import read_manifest
from voice_assist.training.data.synthesis import TrainingClip, plan_held_out, synthesise
from voice_assist.types import RATE

SPEECH = ROOT.parent / "shared" / "speech"  # human speech; not part of the product
SEED = 1  # of the training run, so that the held-out voices are those it never heard
NOISES = 8
NOISE_LENGTH = 20.0  # [s]


def synthetic_commands(thin: int = 1) -> Path:
    """Commands and near misses in voices, variants and an accent that training never used.

    Args:
        thin: One clip in so many.

    Returns:
        The manifest; sound is made at the first call and kept.
    """
    folder = CACHE / "held_out"
    everything = folder / "manifest.csv"
    if not everything.is_file():
        clips = synthesise(plan_held_out(SEED), ROOT / ".cache" / "training" / "held_out")
        _write(folder, clips)
    with everything.open(newline="", encoding="utf-8") as file:
        rows = [(row["path"], row["transcript"]) for row in csv.DictReader(file)]
    manifest = folder / f"manifest_{thin}.csv"
    _table(manifest, rows[::thin])
    return manifest


def theatre() -> Path:
    """Folder with theatre noise of several seeds."""
    folder = CACHE / "theatre"
    folder.mkdir(parents=True, exist_ok=True)
    for seed in range(NOISES):
        path = folder / f"{seed}.wav"
        if not path.is_file():
            soundfile.write(path, theatre_noise(NOISE_LENGTH, 0.1, 100 + seed), RATE)
    return folder


def people(split: str, thin: int = 1, only: str = "") -> Path | None:
    """Human speech of a split that training never used.

    Args:
        split: "dev" or "false_accept_dev".
        thin: One clip in so many.
        only: A transcript that all clips shall have; empty: any.

    Returns:
        A manifest that points to the recordings; None where there are none.
    """
    rows = [r for r in read_manifest(SPEECH) if r.split == split]
    rows = [r for r in rows if not only or r.transcript == only][::thin]
    if not rows:
        return None
    CACHE.mkdir(parents=True, exist_ok=True)
    manifest = CACHE / f"{split}_{only or 'all'}_{thin}.csv"
    _table(manifest, ((str(r.path.resolve()), r.transcript) for r in rows))
    return manifest


def _write(folder: Path, clips: Iterable[TrainingClip]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for i, clip in enumerate(clips):
        name = f"{i:05d}.wav"
        soundfile.write(folder / name, np.asarray(clip.samples), RATE)
        rows.append((name, clip.text))
    _table(folder / "manifest.csv", rows)


def _table(path: Path, rows: Iterable[tuple[str, str]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(("path", "transcript"))
        table.writerows(rows)
