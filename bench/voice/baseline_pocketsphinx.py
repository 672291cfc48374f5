# SPDX-License-Identifier: BSD-3-Clause
"""pocketsphinx in keyword mode beside this package, on the same clips and commands.

Each clip is streamed in 32 ms blocks with quiet around it; a keyword counts when it appears, and
the decoder then begins anew, as its documentation shows. One threshold for all phrases.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.voice import clips, evaluate_once
from bench.voice.evaluate_once import FOLDER, Evaluated, Row
from support.exact_bounds import at_least, rate_at_most
from support.figures import ROOT, Figure
from voice_assist.audio.source import FRAME
from voice_assist.audio.wav_file import read_sound
from voice_assist.config import load_voice_config
from voice_assist.evaluation.evaluator import AFTER, BEFORE
from voice_assist.types import RATE, Samples

THRESHOLDS = ("1e-5", "1e-10", "1e-20", "1e-30")
TALK = (
    1 if evaluate_once.THIN == 1 else 4
)  # one clip of talk in so many: a pass per threshold is slow

Hear = Callable[[Samples], tuple[str, ...]]  # commands taken from a clip


@dataclass(frozen=True)
class Counts:
    """What came of a set."""

    said: int  # clips with a command
    right: int  # of these: that command taken and no other
    hours: float  # of the clips without one [h]
    taken: Counter[str]  # in these


def measure() -> list[Figure]:
    """A row per threshold and set, ours first."""
    sets: dict[str, Evaluated | None] = {
        "synthetic commands": evaluate_once.evaluated(
            "synthetic_keywords", clips.synthetic_commands(4 * evaluate_once.THIN)
        ),
        "human stop": evaluate_once.human_stop(),
        "human talk": evaluate_once.human_talk(),
    }
    phrases = load_voice_config().commands.phrases
    figures, table = [], {}
    for name, found in sets.items():
        if found is None:
            print(f"no human speech in ../shared/speech: {name} left out")
            continue
        rows = found.rows[:: TALK if name == "human talk" else 1]
        figures += figures_of(f"{name}, voice_assist", count(rows, lambda row: row.taken))
        sounds = {row.path: read_sound(ROOT / row.path) for row in rows}
        for threshold in THRESHOLDS:
            hear = keyword_decoder(phrases, threshold)
            theirs = count(rows, lambda row: hear(sounds[row.path]))  # noqa: B023 - used at once
            figures += figures_of(f"{name}, pocketsphinx {threshold}", theirs)
            table[f"{name}, {threshold}"] = to_json(theirs)
    text = json.dumps(table, indent=1) + "\n"
    (FOLDER / "keywords_table.json").write_text(text, encoding="utf-8")
    return figures


def count(rows: Sequence[Row], hear: Callable[[Row], tuple[str, ...]]) -> Counts:
    """Count what is taken from each clip against what is said in it."""
    said = right = 0
    seconds, taken = 0.0, Counter[str]()
    for row in rows:
        heard = hear(row)
        if row.command:
            said += 1
            right += set(heard) == {row.command}
        else:
            seconds += row.seconds
            taken.update(heard)
    return Counts(said, right, seconds / 3600.0, taken)


def keyword_decoder(phrases: Sequence[str], threshold: str) -> Hear:
    """Pocketsphinx with its own English model, listening for phrases."""
    from pocketsphinx import Decoder

    listing = clips.CACHE / f"keywords_{threshold}.txt"
    listing.parent.mkdir(parents=True, exist_ok=True)
    listing.write_text("".join(f"{p} /{threshold}/\n" for p in phrases), encoding="utf-8")
    decoder = Decoder(kws=str(listing), samprate=float(RATE), loglevel="FATAL")
    return lambda samples: _stream(decoder, samples)


def _stream(decoder: Any, samples: Samples) -> tuple[str, ...]:
    rng = np.random.default_rng(0)
    length = len(samples) + round((BEFORE + AFTER) * RATE)
    sound = 2.0e-4 * rng.standard_normal(-(-length // FRAME) * FRAME)
    start = round(BEFORE * RATE)
    sound[start : start + len(samples)] += samples
    pcm = np.round(np.clip(sound, -1.0, 1.0) * 32767).astype("<i2")
    taken = []
    decoder.start_utt()
    for block in pcm.reshape(-1, FRAME):
        decoder.process_raw(block.tobytes(), False, False)
        if (heard := decoder.hyp()) is not None:
            taken.append(heard.hypstr.strip())
            decoder.end_utt()
            decoder.start_utt()
    decoder.end_utt()
    return tuple(taken)


def figures_of(name: str, counts: Counts) -> list[Figure]:
    """Share right, and false commands per hour."""
    figures = []
    if counts.said:
        least = at_least(counts.right, counts.said)
        note = f"({counts.right} of {counts.said}, at least {least:.3f} with 95 %)"
        figures.append(Figure(f"{name}: right", counts.right / counts.said, "of all", note=note))
    if counts.hours > 0.0:
        total, stops = counts.taken.total(), counts.taken["stop"]
        most = rate_at_most(total, counts.hours)
        note = f"({total} in {counts.hours:.3f} h, {stops} of them stop; at most {most:.1f}/h)"
        figures.append(Figure(f"{name}: false commands", total / counts.hours, "per h", note=note))
    return figures


def to_json(counts: Counts) -> dict[str, Any]:
    """Counts as plain data."""
    return {
        "said": counts.said,
        "right": counts.right,
        "hours": counts.hours,
        "taken": dict(counts.taken),
    }
