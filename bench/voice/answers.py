# SPDX-License-Identifier: BSD-3-Clause
"""A "stop" while the robot speaks an answer, and what the answers themselves are taken for.

The subset is fixed: every third of the people of ../shared/speech/dev who say "stop"; where they
are absent, every native synthetic voice once. SHARE=0.2 takes the same fifth every time.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from bench.voice.hearing import pieces
from bench.voice.hearing.pieces import SceneRecord
from bench.voice.material.answers import PER_CHUNK, AnswerTrial
from bench.voice.material.held_out_voices import natives, spread
from bench.voice.material.synthesis import DEV, SpokenClip, recorded, spoken
from bench.voice.outcomes import delays, motions, share_of_voices, voice
from bench.voice.trials import STOP
from support.figures import Figure
from voice_assist.answers.sentences import catalogue

SEED = 29
EVERY = 3  # of the people
STATES = {False: "at rest", True: "moving"}
CONDITIONS = ((12.0, False), (6.0, False), (0.0, False), (6.0, True))  # [dB] of the word; moving
ALONE = "answers alone, at rest"


def measure() -> list[Figure]:
    """Share heard and delay by level, and commands taken from the answers themselves."""
    plans = dict(_plans())
    found, count = pieces.found("answers", plans, PER_CHUNK, is_moving=True)
    figures = [count]
    for name, records in found.items():
        figures += _alone(name, records) if name.startswith(ALONE) else _of(name, records)
    return figures


def _of(name: str, records: Sequence[SceneRecord]) -> list[Figure]:
    stopped = [r for r in records if "stop" in r.heard.taken]
    heard = ((voice(r), "stop" in r.heard.taken) for r in records)
    figures = [share_of_voices(f"{name}: stopped", heard)]
    times = delays(stopped)
    if times:
        quantiles = {f"p{q}": float(np.percentile(times, q)) for q in (50, 99)}
        figures += [Figure(f"{name}: {q}", value, "ms") for q, value in quantiles.items()]
    return figures


def _alone(name: str, records: Sequence[SceneRecord]) -> list[Figure]:
    figures = []
    for what, commands in (("motion", motions()), ("stop", {"stop"})):
        said = [r.label["text"] for r in records if commands & set(r.heard.taken)]
        note = f"(of {len(records)} sentences{''.join(f', {text!r}' for text in said)})"
        figures.append(Figure(f"{name}: {what} taken", len(said), "", 0.0, note=note))
    return figures


def _plans() -> Iterator[tuple[str, list[AnswerTrial]]]:
    people = [clip for clip in recorded(DEV) if clip.text in STOP][::EVERY]
    who = "human" if people else "synthetic"
    words: Sequence[SpokenClip] = people or spoken(spread(STOP, natives().present, 1, SEED))
    sentences = catalogue()
    quiet = [AnswerTrial(word, "", 0.0, i, True) for i, word in enumerate(words)]
    yield f'{who} "stop", nothing spoken, moving', quiet
    at_rest = [replace(trial, is_moving=False) for trial in quiet]
    yield f'{who} "stop", nothing spoken, at rest', at_rest
    for level, is_moving in CONDITIONS:
        trials = [
            AnswerTrial(word, sentences[i % len(sentences)], level, i, is_moving)
            for i, word in enumerate(words)
        ]
        yield f'{who} "stop" {level:g} dB over an answer, {STATES[is_moving]}', trials
    yield ALONE, [AnswerTrial(None, text, 0.0, i, False) for i, text in enumerate(sentences)]
