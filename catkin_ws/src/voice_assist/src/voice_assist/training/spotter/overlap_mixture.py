# SPDX-License-Identifier: BSD-3-Clause
"""Windows to train the spotter on that hears "stop" while others talk, drawn afresh each time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.signal import fftconvolve

from voice_assist.audio.mixing import speech_power
from voice_assist.recognizer.mel import SAMPLES_PER_STATE
from voice_assist.spotter.overlap import WINDOW
from voice_assist.training.data.augment import resample_linear
from voice_assist.training.data.noise import Float, Surroundings, background
from voice_assist.training.data.synthesis import TrainingClip
from voice_assist.training.spotter.streams import speech_span
from voice_assist.types import RATE

_HALF = 0.5  # of the windows hold the word
_TALK, _SECOND = 0.85, 0.15  # probability that somebody talks; that two do
_LEVELS = (-6.0, 20.0)  # [dB] of a word over the talk's active level
_HUMAN = 0.65  # of the words are said by people
_ENDED = 0.4  # [s] the word ends at most so long before the window
_LONG_AGO = (0.75, 1.4)  # [s] before the window's end: a word that counts no more
_SPEED, _TALK_SPEED = (0.85, 1.18), (0.9, 1.1)
_NOISE, _SNR = 0.5, (0.0, 25.0)  # probability, and [dB] of the loudest over it
_ROOM = 0.4  # probability
_FAINTEST, _LOUDEST = -45.0, -3.0  # [dB] of full scale, peak
_PIECE = (0.2, 0.55)  # share of a word that is no word yet
_OTHER, _PIECES, _OLD = 0.40, 0.13, 0.07  # of the windows without the word; the rest is talk
_OFTEN = frozenset(("up", "top", "step", "stuff", "stopped", "stock", "shop", "off", "sob", "spot"))
_LIKE = 0.6  # of the other words are of these, or said by a synthetic voice to be like it


@dataclass(frozen=True, eq=False)
class Talk:
    """Somebody's talk and its power while he talks."""

    samples: NDArray[np.int16]  # (n,)
    power: float


@dataclass(frozen=True, eq=False)
class OverlapMaterial:
    """What windows are made of."""

    human: Sequence[TrainingClip]  # people saying the word
    synthetic: Sequence[TrainingClip]
    others: Sequence[TrainingClip]  # other short words
    near: Sequence[TrainingClip]  # those that are like it
    talk: Sequence[Talk]
    around: Surroundings


@dataclass(frozen=True, eq=False)
class Batch:
    """Windows and their answers."""

    sound: Float  # (batch, WINDOW)
    is_word: Float  # (batch,), 1 or 0
    frames: Float  # (batch, WINDOW / SAMPLES_PER_STATE), 1 where the word is, 0 elsewhere


def arrange(
    human: Sequence[TrainingClip],
    synthetic: Sequence[TrainingClip],
    others: Sequence[TrainingClip],
    near: Sequence[TrainingClip],
    around: Surroundings,
) -> OverlapMaterial:
    """Sort what is like the word out of the others, and measure how loud the talk is."""
    like = [clip for clip in others if clip.text in _OFTEN]
    talk = [Talk(samples, _power(samples)) for samples in around.talkers]
    heard = [one for one in talk if one.power > 0.0]
    return OverlapMaterial(human, synthetic, others, [*near, *like], heard, around)


def _power(samples: NDArray[np.int16]) -> float:
    return speech_power(samples.astype(np.float32) / np.float32(32768))


def draw(material: OverlapMaterial, count: int, rng: Generator) -> Batch:
    """Mix a batch of windows."""
    sound = np.zeros((count, WINDOW), np.float32)
    is_word = np.zeros(count, np.float32)
    frames = np.zeros((count, WINDOW // SAMPLES_PER_STATE), np.float32)
    for row in range(count):
        is_word[row] = rng.random() < _HALF
        span = _fill(sound[row], material, bool(is_word[row]), rng)
        frames[row, span] = 1.0
    return Batch(sound, is_word, frames)


def _fill(window: Float, material: OverlapMaterial, is_word: bool, rng: Generator) -> slice:
    """Mix one window in place; gives the frames in which the word is."""
    has_talk = rng.random() < _TALK
    if has_talk:
        window += _talk(material, rng)
        if rng.random() < _SECOND:
            window += _talk(material, rng) * np.float32(10 ** (rng.uniform(-12, 0) / 20))
    span = slice(0, 0)
    kind = 1.0 if is_word else rng.random()
    if is_word:
        span = _add(window, *_word(material, rng), rng.uniform(0.0, _ENDED), material, rng)
    elif kind < _OTHER:
        pool = material.near if rng.random() < _LIKE else material.others
        other, loud = _changed(pool[int(rng.integers(len(pool)))], rng)
        _add(window, other, loud, rng.uniform(-0.3, 0.9), material, rng)
    elif kind < _OTHER + _PIECES:
        word, loud = _word(material, rng)
        _add(window, _piece(word, rng), loud, rng.uniform(0.0, 0.6), material, rng)
    elif kind < _OTHER + _PIECES + _OLD:
        span = _add(window, *_word(material, rng), rng.uniform(*_LONG_AGO), material, rng)
    _surround(window, material, rng)
    return span


def _talk(material: OverlapMaterial, rng: Generator) -> Float:
    """A stretch of somebody's talk, of active power 1."""
    one = material.talk[int(rng.integers(len(material.talk)))]
    speed = rng.uniform(*_TALK_SPEED)
    needed = int(WINDOW * speed) + 2
    start = int(rng.integers(max(len(one.samples) - needed, 0) + 1))
    part = resample_linear(one.samples[start : start + needed], speed)[:WINDOW]
    made = np.zeros(WINDOW, np.float32)
    made[: len(part)] = part / np.float32(np.sqrt(one.power))
    return _in_room(made, material, rng)


def _word(material: OverlapMaterial, rng: Generator) -> tuple[Float, float]:
    pool = material.human if rng.random() < _HUMAN else material.synthetic
    return _changed(pool[int(rng.integers(len(pool)))], rng)


def _changed(clip: TrainingClip, rng: Generator) -> tuple[Float, float]:
    """What is loud in a clip, at another speed, and its power."""
    sound = resample_linear(clip.samples, rng.uniform(*_SPEED))
    begin, end = speech_span(sound)
    loud = sound[int(begin * RATE) : int(end * RATE)]
    return loud, max(speech_power(loud), 1e-9)


def _piece(word: Float, rng: Generator) -> Float:
    """The beginning or the end of a word."""
    length = int(len(word) * rng.uniform(*_PIECE))
    return word[:length] if rng.random() < 0.5 else word[len(word) - length :]


def _add(
    window: Float,
    word: Float,
    power: float,
    ended: float,
    material: OverlapMaterial,
    rng: Generator,
) -> slice:
    """Put a word of some power so that it ended so long [s] before the window; gives its frames."""
    level = 10 ** (rng.uniform(*_LEVELS) / 20)  # over talk of power 1
    wet = np.zeros(WINDOW, np.float32)
    end = WINDOW - int(ended * RATE)
    begin = end - len(word)
    first, last = max(begin, 0), min(end, WINDOW)
    if last > first:
        wet[first:last] = word[first - begin : last - begin]
    window += _in_room(wet, material, rng) * np.float32(level / np.sqrt(power))
    return slice(first // SAMPLES_PER_STATE, -(-last // SAMPLES_PER_STATE))


def _in_room(sound: Float, material: OverlapMaterial, rng: Generator) -> Float:
    if rng.random() >= _ROOM:
        return sound
    room = material.around.rooms[int(rng.integers(len(material.around.rooms)))]
    return np.asarray(fftconvolve(sound, room)[: len(sound)], np.float32)


def _surround(window: Float, material: OverlapMaterial, rng: Generator) -> None:
    """Noise under all of it, then the level."""
    is_noisy = rng.random() < _NOISE
    power = float(np.square(window).mean()) or 1.0
    snr = rng.uniform(*_SNR) if is_noisy else rng.uniform(30.0, 60.0)
    under = (
        background(material.around, WINDOW, rng)
        if is_noisy
        else rng.standard_normal(WINDOW).astype(np.float32)
    )
    window += under * np.float32(np.sqrt(power) * 10 ** (-snr / 20))
    peak = 10 ** (rng.uniform(_FAINTEST, _LOUDEST) / 20)
    window *= np.float32(peak / (float(np.abs(window).max()) + 1e-9))
