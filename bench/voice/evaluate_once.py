# SPDX-License-Identifier: BSD-3-Clause
"""Labelled sound through the command that `make evaluate` runs; each set once per bench."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from bench.common import resumable
from bench.voice.material import clips as voice_sets
from support.figures import RESULTS, ROOT
from voice_assist.evaluation.evaluator import ClaimedCommand

KEEP = bool(os.environ.get("KEEP"))  # use the results that are there, measure the others
THIN = int(os.environ.get("THIN", "3"))  # one clip in so many of noise, words and talk; 1: all
JOBS = os.environ.get("JOBS", "")  # processes; empty: one per core
FOLDER = RESULTS / "voice"


@dataclass(frozen=True)
class EvaluatedClip:
    """What a clip came to."""

    path: str
    transcript: str
    command: str  # empty: none was said
    taken: tuple[str, ...]
    seconds: float  # [s]
    claims: tuple[ClaimedCommand, ...]


@dataclass(frozen=True)
class Evaluated:
    """A set of clips after evaluation."""

    name: str
    figures: Mapping[str, Any]  # as `make evaluate` writes them
    rows: tuple[EvaluatedClip, ...]

    @property
    def hours(self) -> float:
        """Length of all clips [h]."""
        return sum(row.seconds for row in self.rows) / 3600.0


@cache
def evaluated(
    name: str,
    manifest: Path,
    noise: Path | None = None,
    snr: float = 0.0,
) -> Evaluated:
    """Evaluate a manifest; figures go to bench/results/voice/<name>.json.

    Args:
        name: Of the set.
        manifest: CSV of clips.
        noise: Folder of sound to add; None: none.
        snr: Speech over that noise [dB].
    """
    out, details = FOLDER / f"{name}.json", resumable.CACHE / "details" / f"{name}.csv"
    if not (KEEP and out.is_file() and details.is_file()):
        FOLDER.mkdir(parents=True, exist_ok=True)
        details.parent.mkdir(parents=True, exist_ok=True)
        command = [sys.executable, "-m", "voice_assist.cli.main"]
        command += ["evaluate", str(manifest), "--out", str(out), "--details", str(details)]
        if noise is not None:
            command += ["--noise", str(noise.relative_to(ROOT)), "--snr", str(snr)]
        if JOBS:
            command += ["--jobs", JOBS]
        subprocess.run(command, check=True, cwd=ROOT)
    return Evaluated(name, json.loads(out.read_text(encoding="utf-8")), read_rows(details))


def read_rows(path: Path) -> tuple[EvaluatedClip, ...]:
    """Lines of the details that an evaluation wrote."""
    with path.open(newline="", encoding="utf-8") as file:
        return tuple(
            EvaluatedClip(
                path=line["path"],
                transcript=line["transcript"],
                command=line["command"],
                taken=tuple(filter(None, line["taken"].split("|"))),
                seconds=float(line["seconds"]),
                claims=tuple(ClaimedCommand(**claim) for claim in json.loads(line["claims"])),
            )
            for line in csv.DictReader(file)
        )


def quiet() -> Evaluated:
    """All held-out synthetic clips without noise."""
    return evaluated("synthetic_quiet", voice_sets.synthetic_commands())


def noisy(snr: int) -> Evaluated:
    """One held-out synthetic clip in THIN, in theatre noise."""
    clips = voice_sets.synthetic_commands(THIN)
    return evaluated(f"synthetic_{snr}dB", clips, voice_sets.theatre(), snr)


def human_stop() -> Evaluated | None:
    """People who say "stop"; None where there are no recordings."""
    manifest = voice_sets.people("dev", only="stop")
    return evaluated("human_stop", manifest) if manifest else None


def human_words() -> Evaluated | None:
    """People who say single words; None where there are no recordings."""
    manifest = voice_sets.people("dev", THIN)
    return evaluated("human_words", manifest) if manifest else None


def human_talk() -> Evaluated | None:
    """People who talk; None where there are no recordings."""
    manifest = voice_sets.people("false_accept_dev", 2 * THIN)
    return evaluated("human_talk", manifest) if manifest else None
