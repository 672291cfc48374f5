# SPDX-License-Identifier: BSD-3-Clause
"""Sound files and who says what in them: prompts spoken once, and people where present."""

from __future__ import annotations

import csv
import hashlib
import os
from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path

import soundfile

from bench.common import resumable
from bench.common.part import HUMAN
from bench.voice.material import clips as voice_sets
from support.figures import ROOT
from voice_assist.training.data.human import SPEECH_KINDS, read_manifest
from voice_assist.training.data.synthesis import speak_all
from voice_assist.training.data.texts import normalise_text
from voice_assist.training.data.voices import Prompt
from voice_assist.types import RATE


@dataclass(frozen=True, order=True)
class SpokenClip:
    """One sound file."""

    path: str  # relative to the repository
    text: str  # normalised, of other languages as written; empty where nobody knows
    engine: str  # HUMAN for people
    voice: str


DEV, TALK = "dev", "false_accept_dev"  # splits that training never used


def spoken(prompts: Sequence[Prompt]) -> list[SpokenClip]:
    """Speak prompts, or find them spoken; those that an engine cannot say are left out.

    Args:
        prompts: Sorted by engine and voice.
    """
    key = hashlib.sha256(repr(list(prompts)).encode()).hexdigest()[:16]
    folder = resumable.CACHE / "spoken" / key
    index = folder / "index.csv"
    if not index.is_file():
        _speak(prompts, folder, index)
    with index.open(newline="", encoding="utf-8") as file:
        return [SpokenClip(**line) for line in csv.DictReader(file)]


def recorded(*splits: str) -> list[SpokenClip]:
    """People of some splits, in the order of their manifest; none where it is absent."""
    return [
        SpokenClip(
            os.path.relpath(row.path, ROOT),
            normalise_text(row.transcript),
            HUMAN,
            row.speaker or row.source,
        )
        for row in read_manifest(voice_sets.SPEECH)
        if row.split in splits and row.kind in SPEECH_KINDS
    ]


def _speak(prompts: Sequence[Prompt], folder: Path, index: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    found = []
    said = speak_all(prompts, ROOT / ".cache" / "training" / "held_out")
    for number, (prompt, sound) in enumerate(said):
        path = folder / f"{number:05d}.wav"
        soundfile.write(path, sound, RATE)
        clip = str(path.relative_to(ROOT)), prompt.text, prompt.engine, prompt.voice
        found.append(SpokenClip(*clip))
    if len(found) < len(prompts):
        print(f"{len(prompts) - len(found)} of {len(prompts)} prompts gave no sound")
    unfinished = index.with_suffix(".tmp")
    with unfinished.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(field.name for field in fields(SpokenClip))
        table.writerows(astuple(one) for one in found)
    unfinished.rename(index)
