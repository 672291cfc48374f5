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

import yaml

from bench.voice import clips as voice_sets
from support.figures import RESULTS, ROOT
from voice_assist.config import CONFIG_DIR, SECTIONS
from voice_assist.evaluation.evaluator import Claim

KEEP = bool(os.environ.get("KEEP"))  # use the results that are there, measure the others
THIN = int(os.environ.get("THIN", "3"))  # one clip in so many of noise, words and talk; 1: all
JOBS = os.environ.get("JOBS", "")  # processes; empty: one per core
FOLDER = RESULTS / "voice"


@dataclass(frozen=True)
class Row:
    """What a clip came to."""

    path: str
    transcript: str
    command: str  # empty: none was said
    taken: tuple[str, ...]
    seconds: float  # [s]
    claims: tuple[Claim, ...]


@dataclass(frozen=True)
class Evaluated:
    """A set of clips after evaluation."""

    name: str
    figures: Mapping[str, Any]  # as `make evaluate` writes them
    rows: tuple[Row, ...]

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
    changes: tuple[tuple[str, str], ...] = (),
) -> Evaluated:
    """Evaluate a manifest; figures go to bench/results/voice/<name>.json.

    Args:
        name: Of the set.
        manifest: CSV of clips.
        noise: Folder of sound to add; None: none.
        snr: Speech over that noise [dB].
        changes: Settings to replace, path such as "audio.denoise.mode" and value.
    """
    out, details = FOLDER / f"{name}.json", voice_sets.CACHE / "details" / f"{name}.csv"
    if not (KEEP and out.is_file() and details.is_file()):
        FOLDER.mkdir(parents=True, exist_ok=True)
        details.parent.mkdir(parents=True, exist_ok=True)
        command = [sys.executable, "-m", "voice_assist.cli.main"]
        if changes:
            command += ["--config", str(changed_config(changes))]
        command += ["evaluate", str(manifest), "--out", str(out), "--details", str(details)]
        if noise is not None:
            command += ["--noise", str(noise.relative_to(ROOT)), "--snr", str(snr)]
        if JOBS:
            command += ["--jobs", JOBS]
        subprocess.run(command, check=True, cwd=ROOT)
    return Evaluated(name, json.loads(out.read_text(encoding="utf-8")), read_rows(details))


def changed_config(changes: tuple[tuple[str, str], ...]) -> Path:
    """Folder of settings that differ from the shipped ones in what is given."""
    label = "_".join(f"{path}={value}" for path, value in changes)
    folder = voice_sets.CACHE / "config" / label
    folder.mkdir(parents=True, exist_ok=True)
    for section in SECTIONS:
        data = yaml.safe_load((CONFIG_DIR / f"{section}.yaml").read_text(encoding="utf-8"))
        for path, value in changes:
            first, *between, last = path.split(".")
            if first == section:
                branch = data
                for key in between:
                    branch = branch[key]
                branch[last] = value
        text = yaml.safe_dump(data, sort_keys=False)
        (folder / f"{section}.yaml").write_text(text, encoding="utf-8")
    return folder


def read_rows(path: Path) -> tuple[Row, ...]:
    """Lines of the details that an evaluation wrote."""
    with path.open(newline="", encoding="utf-8") as file:
        return tuple(
            Row(
                path=line["path"],
                transcript=line["transcript"],
                command=line["command"],
                taken=tuple(filter(None, line["taken"].split("|"))),
                seconds=float(line["seconds"]),
                claims=tuple(Claim(**claim) for claim in json.loads(line["claims"])),
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
