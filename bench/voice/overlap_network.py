# SPDX-License-Identifier: BSD-3-Clause
"""The network that hears "stop" over talk, alone: share heard against false alarms an hour.

THIN takes one piece of talk and one word in so many (3); OVERLAP names another file of weights.
Rates of less than one alarm in the talk that there is are left out.
"""

from __future__ import annotations

import os
import time
from pathlib import Path

import numpy as np
import torch

from bench.common.resumable import measured
from bench.voice.material.over_talk import (
    LATEST,
    alarms,
    allowed,
    over_talk,
    scores_of,
    threshold_at,
)
from bench.voice.material.synthesis import DEV, TALK, SpokenClip, recorded
from bench.voice.outcomes import in_percent, share_of_voices
from bench.voice.trials import THIN, WHOLE
from support.figures import ROOT, Figure
from voice_assist.audio.sound_file import read_sound
from voice_assist.recognizer.precision import dtype_for, quick
from voice_assist.spotter.overlap import PATH, WINDOW, OverlapNetwork, read_overlap
from voice_assist.types import RATE, Samples

WORD = "stop"
LEVELS = (12.0, 6.0, 0.0, -6.0)  # [dB] of the word over the talk
RATES = (0.5, 1.0, 3.0, 6.0, 12.0)  # [1/h] of false alarms in talk
GOALS = {"12 dB over talk": 0.99, "6 dB over talk": 0.95, "0 dB over talk": 0.80, "alone": 0.99}
GOAL_RATE = 6.0  # [1/h] at which they hold
SHORTEST = 2.0  # [s] of talk


def measure() -> list[Figure]:
    """Table of the network on people whom training never heard; empty without them or weights."""
    path = Path(os.environ.get("OVERLAP", PATH))
    every = [c for c in recorded(DEV) if c.text == WORD]
    words = every[::THIN]
    talk = [s for c in _others() if len(s := read_sound(ROOT / c.path)) >= SHORTEST * RATE][::THIN]
    if not path.is_file() or not words or not talk:
        print(f"overlap_network left out: it needs {path} and people in ../shared/speech")
        return []
    torch.set_num_threads(1)
    network = quick(read_overlap(path)[0], dtype_for("cpu"))
    hours = sum(map(len, talk)) / RATE / 3600
    heights = [height for sound in talk for height in alarms(scores_of(network, sound))]
    figures = [
        measured(len(words), "words", len(every[::WHOLE])),
        Figure("talk", hours, "h", note=f"({len(talk)} pieces, nobody says the word)"),
        Figure("look", 1e3 * _cost(network), "ms", 15.0, note="(one thread)"),
    ]
    found = {f"{level:g} dB over talk": _best(network, words, talk, level) for level in LEVELS}
    found["alone"] = _best(network, words, [], 0.0)
    for rate in RATES:
        if not (count := allowed(hours, rate)):
            continue
        threshold = threshold_at(heights, hours, rate)
        note = f"alarms allowed: {count} in {hours:.2f} h"
        figures.append(Figure(f"threshold at {rate:g} an hour", threshold, "nat", note=note))
        for name, best in found.items():
            heard = zip((c.voice for c in words), (best >= threshold).tolist(), strict=True)
            goal = GOALS.get(name) if rate == GOAL_RATE else None
            title = f"{name}, {rate:g} an hour"
            figures.append(share_of_voices(title, heard, in_percent(goal), note=note))
    return figures


def _others() -> list[SpokenClip]:
    return [clip for clip in recorded(TALK) if WORD not in clip.text.split()]


def _best(
    network: OverlapNetwork, words: list[SpokenClip], talk: list[Samples], level: float
) -> np.ndarray:
    """Highest score of each word, from 0.1 s before its end on."""
    best = []
    for index, clip in enumerate(words):
        word = read_sound(ROOT / clip.path)
        under = talk[index * 7 % len(talk)] if talk else None
        sound, end = over_talk(word, under, level, np.random.default_rng(index))
        best.append(float(scores_of(network, sound, end - 0.1, end + LATEST).max()))
    return np.array(best)


def _cost(network: OverlapNetwork) -> float:
    """CPU time of a network pass [s], the median of several."""
    window = torch.zeros(1, WINDOW)
    times = []
    with torch.inference_mode():
        for _ in range(15):
            begin = time.process_time()
            network(window)
            times.append(time.process_time() - begin)
    return float(np.median(times))
