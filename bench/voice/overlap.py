# SPDX-License-Identifier: BSD-3-Clause
"""A "stop" while others talk, at rest and while the robot moves; two commands in one moment.

SHARE=0.33 takes the same third of each set every time.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from bench.voice.hearing import pieces
from bench.voice.hearing.pieces import SceneRecord
from bench.voice.hearing.replay_stream import WAYS, Way, way_name
from bench.voice.material.held_out_voices import natives, spread
from bench.voice.material.overlap import PER_CHUNK, OverlapTrial
from bench.voice.material.synthesis import DEV, TALK, SpokenClip, recorded, spoken
from bench.voice.outcomes import (
    delays,
    hours,
    in_percent,
    motions,
    processor,
    share_of_voices,
    voice,
)
from bench.voice.trials import STOP
from support.figures import Figure, rate

SEED = 11
LEVELS = (12.0, 6.0, 0.0, -6.0)  # [dB] of the word over the talk
AT_ONCE = (6.0, 0.0, -6.0)  # [dB] of "stop" over the other command
OTHER = "pull more"
STATES = {False: "at rest", True: "moving"}
RECALL = {12.0: 0.99, 6.0: 0.95, 0.0: 0.80}  # share heard while the robot moves
LATE = 500.0  # [ms] over talk, while the robot moves: the longest of few


def measure() -> list[Figure]:
    """Share heard, latency, commands at once, and false stops; the robot at rest and moving."""
    every = dict(plans())
    if not every:
        print("no human speech in ../shared/speech: overlap left out")
        return []
    found, count = pieces.found("overlap", every, PER_CHUNK, is_moving=True)
    figures = [count]
    for name, records in found.items():
        trial = every[name][0]
        figures += _of(name, trial, records)
    return figures


def _of(name: str, trial: OverlapTrial, records: Sequence[SceneRecord]) -> list[Figure]:
    if trial.kind == "talk alone":
        stops = sum(r.heard.taken.count("stop") for r in records)
        limit = 6.0 if trial.is_moving else 0.5
        return [
            rate(f"{name}: false stops", stops, hours(records), limit),
            _moved(name, records),
            _load(name, records),
        ]
    target = RECALL.get(trial.level) if trial.is_moving and trial.kind == "under talk" else None
    if trial.kind == "at once" and trial.level >= 0.0:
        target = 1.0
    stopped = [r for r in records if "stop" in r.heard.taken]
    heard = ((voice(r), "stop" in r.heard.taken) for r in records)
    figures = [share_of_voices(f"{name}: stopped", heard, in_percent(target))]
    if trial.kind == "at once":
        return [*figures, _moved(name, records)]
    return figures + (_latency(name, stopped) if trial.is_moving and trial.way == "both" else [])


def _moved(name: str, records: Sequence[SceneRecord]) -> Figure:
    """Scenes in which a motion was taken."""
    moved = ((voice(r), not motions().isdisjoint(r.heard.taken)) for r in records)
    return share_of_voices(f"{name}: motion taken", moved, 0.0, at_most=True)


def _load(name: str, records: Sequence[SceneRecord]) -> Figure:
    """Near 100 % hearing falls behind, and each stop is late."""
    return Figure(f"{name}: processor", processor(records), "%")


def _latency(name: str, stopped: Sequence[SceneRecord]) -> list[Figure]:
    """From the end of the word to the first stop; where that came before, the word's beginning."""
    times = delays(stopped)
    if not times:
        return []
    note = f"(of {len(times)} that were heard)"
    return [
        Figure(f"{name}: p50", float(np.median(times)), "ms", note=note),
        Figure(f"{name}: longest", max(times), "ms", LATE, note=note),
    ]


def plans() -> Iterator[tuple[str, list[OverlapTrial]]]:
    """All trials by their name; none without people in ../shared/speech."""
    humans = [clip for clip in recorded(DEV) if clip.text in STOP][::2]
    talk = _talk()
    if not humans or not talk:
        return
    voices = spoken(spread(STOP, natives().present, 2, SEED))
    for who, words in (("human", humans), ("synthetic", voices)):
        for level, is_moving in product(LEVELS, STATES):
            yield from _under(who, words, talk, level, is_moving, "both")
        for level, way in product((12.0, 0.0), WAYS[1:]):
            yield from _under(who, words, talk, level, True, way)
    others = spoken(spread((OTHER,), natives().present, 2, SEED))
    for level, is_moving in product(AT_ONCE, STATES):
        name = f'"stop" {level:g} dB over {OTHER!r}, {STATES[is_moving]}'
        turned = [*others[len(others) // 2 :], *others[: len(others) // 2]]  # by another voice
        pairs = zip(voices, turned, strict=False)
        yield (
            name,
            [
                OverlapTrial("at once", word, other, level, index, is_moving)
                for index, (word, other) in enumerate(pairs)
            ],
        )
    for is_moving, way in product(STATES, WAYS):
        trials = [
            OverlapTrial("talk alone", clip, None, 0.0, index, is_moving, way)
            for index, clip in enumerate(talk)
        ]
        yield f"human talk, {STATES[is_moving]}, {way_name(way)}", trials


def _under(
    who: str,
    words: Sequence[SpokenClip],
    talk: Sequence[SpokenClip],
    level: float,
    is_moving: bool,
    way: Way,
) -> Iterator[tuple[str, list[OverlapTrial]]]:
    name = f'{who} "stop" {level:g} dB over talk, {STATES[is_moving]}, {way_name(way)}'
    trials = [
        OverlapTrial("under talk", word, talk[index % len(talk)], level, index, is_moving, way)
        for index, word in enumerate(words)
    ]
    yield name, trials


def _talk() -> list[SpokenClip]:
    """Clips of people without a transcript; in none of them a command is known to be said."""
    return [clip for clip in recorded(TALK) if not clip.text]
