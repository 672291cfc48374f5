# SPDX-License-Identifier: BSD-3-Clause
"""Loud noise that has just ended, and a "stop" said into the quiet: is it heard?"""

from __future__ import annotations

from itertools import product

import numpy as np

from bench.safety.sound.kinds import VOICES, Sound
from bench.voice.material import theatre_noise
from support.figures import Figure, share
from support.theatre_sound import speak
from voice_assist.audio.source import Framer
from voice_assist.evaluation.evaluator import StreamClock
from voice_assist.pipeline.pipeline import Pipeline
from voice_assist.types import RATE, Match, Mode, UtteranceDecision

NOISES = ("suction", "fans", "drills", "white", "mains")
LEVELS = (-3.0, -9.0, -15.0, -21.0)  # [dB] of full scale, RMS before it is clipped
PAUSES = (0.3, 0.8, 1.5)  # [s] from the noise's end to the word
LONG = 6.0  # [s] of noise
AFTER = 1.5  # [s] in which it has to be heard
TIMES = 4  # each, in voices one after the other


def figures(pipeline: Pipeline, clock: StreamClock) -> list[Figure]:
    """Of each pause; without noise before it beside them."""
    trials = list(product(NOISES, LEVELS, range(TIMES)))
    found = []
    for pause in PAUSES:
        heard = [_hears(pipeline, clock, *trial, pause) for trial in trials]
        found.append(_share(f"{pause:g} s after loud noise", heard))
    quiet = [_hears(pipeline, clock, "", 0.0, seed, 1.5) for seed in range(8 * TIMES)]
    return [*found, _share("in quiet, without noise before it", quiet)]


def _share(name: str, heard: list[bool]) -> Figure:
    return share(f'"stop" {name}: heard', sum(heard), len(heard))


def _hears(
    pipeline: Pipeline, clock: StreamClock, kind: str, level: float, seed: int, pause: float
) -> bool:
    rng = np.random.default_rng((seed, round(-level)))
    voice, rate = VOICES[seed % len(VOICES)], int(rng.integers(130, 190))
    before = _noise(kind, level, seed) if kind else room(LONG, rng)
    parts = (before, room(pause, rng), speak("stop", voice, rate), room(AFTER, rng))
    sound = np.clip(np.concatenate(parts, dtype=float), -1.0, 1.0)
    pipeline.reset()
    pipeline.set_mode(Mode.ACTIVE, "bench")
    taken = []
    for frame in Framer().push(sound, clock() + 1.0):
        clock.begin(frame.stamp + frame.duration)
        decided = [e.outcome for e in pipeline(frame) if isinstance(e, UtteranceDecision)]
        clock.end()
        taken += [one.command for one in decided if isinstance(one, Match)]
    return "stop" in taken


def _noise(kind: str, level: float, seed: int) -> Sound:
    rng = np.random.default_rng(seed)
    if kind == "white":
        sound = rng.standard_normal(round(LONG * RATE))
    elif kind == "mains":
        sound = np.sin(2 * np.pi * 50.0 * np.arange(round(LONG * RATE)) / RATE)
        sound += 0.3 * np.sign(sound) + 1e-3 * rng.standard_normal(len(sound))
    else:
        sound = theatre_noise.make(kind, LONG, seed).astype(float)
    return np.asarray(10 ** (level / 20) * sound / np.sqrt(np.mean(np.square(sound))), float)


def room(seconds: float, rng: np.random.Generator) -> Sound:
    """A quiet room, at 16 kHz. Shape (n,)."""
    return 1e-3 * rng.standard_normal(round(seconds * RATE))
