# SPDX-License-Identifier: BSD-3-Clause
"""Streams to train the spotter on: clips one after the other over a background, as in a room.

Streams, not clips, since the spotter never sees a clip: before a word there is what was said
before it, behind it what comes next, and the phase of its steps to the word is any.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.random import Generator

from voice_assist.audio.mixing import BLOCK, speech_blocks
from voice_assist.training.data.augment import Strength, colour, resample_linear
from voice_assist.training.data.noise import Float, Surroundings, background
from voice_assist.training.data.synthesis import TrainingClip
from voice_assist.types import RATE

WORD = "stop"
LENGTH = 20.0  # [s] of a stream at most, except for one with a longer clip
_GAP = (0.08, 1.0)  # [s] between two clips
_FAINTEST = -90.0  # [dB] of full scale


@dataclass(frozen=True, eq=False)
class LabelledStream:
    """Sound, and when the word was said in it."""

    sound: Float  # (n,), 16 kHz
    words: tuple[tuple[float, float], ...]  # [s] begin and end of each WORD


@dataclass(frozen=True)
class Style:
    """How far a set of clips is changed."""

    speed: tuple[float, float] = (0.82, 1.22)
    room: float = 0.35  # probability
    noise: float = 0.6  # probability that a stream's background is loud
    snr: tuple[float, float] = (-3.0, 25.0)  # [dB] of that
    talker: float = 0.0  # probability that somebody else talks on all through the stream
    over: tuple[float, float] = (-2.0, 15.0)  # [dB] of the clips over that voice
    again: float = 0.0  # probability that a WORD is said twice
    gap: tuple[float, float] = _GAP


def streams(
    clips: Sequence[TrainingClip], around: Surroundings, style: Style, rng: Generator
) -> Iterator[LabelledStream]:
    """Join clips to streams, in their order.

    Args:
        clips: A text of WORD alone is what shall be found; no other clip may hold it.
        around: Rooms and backgrounds.
        style: How to change the clips.
        rng: Source of chance.
    """
    batch: list[TrainingClip] = []
    length = 0.0
    for clip in clips:
        batch.append(clip)
        length += len(clip.samples) / RATE + sum(style.gap) / 2
        if length >= LENGTH:
            yield _stream(batch, around, style, rng)
            batch, length = [], 0.0
    if batch:
        yield _stream(batch, around, style, rng)


def noise_streams(around: Surroundings, count: int, rng: Generator) -> Iterator[LabelledStream]:
    """Backgrounds, tones and knocks without a word, at any level; now and then digital silence."""
    for _ in range(count):
        sound = np.zeros(int(LENGTH * RATE), np.float32)
        if rng.random() < 0.95:
            sound += background(around, len(sound), rng)
        if rng.random() < 0.3:
            sound += _beeps(len(sound), rng)
        if rng.random() < 0.3:
            sound += _knocks(len(sound), rng)
        yield LabelledStream(_at_level(sound, 10 ** (rng.uniform(-70, -3) / 20)), ())


def _stream(
    clips: Sequence[TrainingClip], around: Surroundings, style: Style, rng: Generator
) -> LabelledStream:
    parts: list[Float] = [_gap(style, rng)]
    words: list[tuple[float, float]] = []
    at = len(parts[0])
    level = 10 ** (rng.uniform(-40, -8) / 20)  # one talker, one distance, as a rule
    for clip in clips:
        times = 2 if clip.text == WORD and rng.random() < style.again else 1
        for _ in range(times):
            plain = resample_linear(clip.samples, rng.uniform(*style.speed))
            if clip.text == WORD:
                begin, end = speech_span(plain)
                words.append((at / RATE + begin, at / RATE + end))
            sound = _colour(plain, around, style, rng)
            parts += [_at_level(sound, level * 10 ** (rng.uniform(-4, 4) / 20)), _gap(style, rng)]
            at += len(parts[-2]) + len(parts[-1])
    sound = _with_talker(np.concatenate(parts), level, around, style, rng)
    return LabelledStream(_with_background(sound, level, around, style, rng), tuple(words))


def _colour(sound: Float, around: Surroundings, style: Style, rng: Generator) -> Float:
    how = Strength(room=style.room)
    coloured = colour(torch.from_numpy(sound)[None], around, how, rng)[0]
    return np.asarray(coloured.numpy(), np.float32)


def speech_span(sound: Float) -> tuple[float, float]:
    """Begin and end of what is loud in a clip [s]; all of it where nothing stands out."""
    found = np.flatnonzero(speech_blocks(sound))
    if not len(found):
        return 0.0, len(sound) / RATE
    return float(found[0]) * BLOCK / RATE, float(found[-1] + 1) * BLOCK / RATE


def _gap(style: Style, rng: Generator) -> Float:
    return np.zeros(int(rng.uniform(*style.gap) * RATE), np.float32)


def _at_level(sound: Float, level: float) -> Float:
    """Scale to an effective value over what is loud in it."""
    loud = sound[np.abs(sound) > 0.1 * np.abs(sound).max()] if len(sound) else sound
    power = float(np.sqrt(np.mean(loud**2))) if len(loud) else 0.0
    scaled = sound * (level / power) if power > 0.0 else sound
    return np.clip(scaled, -1.0, 1.0).astype(np.float32)


def _with_talker(
    sound: Float, level: float, around: Surroundings, style: Style, rng: Generator
) -> Float:
    """One more voice without a pause, as of a robot that replies or of somebody near."""
    if not around.talkers or rng.random() >= style.talker:
        return sound
    said: list[Float] = []
    length = 0
    while length < len(sound):
        voice = around.talkers[int(rng.integers(len(around.talkers)))].astype(np.float32)
        said.append(_at_level(voice, 0.1))
        length += len(voice)
    depth = level * 10 ** (-rng.uniform(*style.over) / 20) / 0.1
    under = np.concatenate(said)[: len(sound)]
    return np.asarray(sound + np.float32(depth) * under, np.float32)


def _with_background(
    sound: Float, level: float, around: Surroundings, style: Style, rng: Generator
) -> Float:
    if rng.random() < style.noise:
        under = background(around, len(sound), rng)
        if rng.random() < 0.15:
            under = under + 0.5 * _beeps(len(sound), rng)
        depth = level * 10 ** (-rng.uniform(*style.snr) / 20)
    else:
        under = rng.standard_normal(len(sound)).astype(np.float32)
        depth = 10 ** (rng.uniform(_FAINTEST, -50.0) / 20)
    mixed = sound + np.float32(depth) * under
    peak = np.abs(mixed).max()
    mixed /= max(float(peak), 1.0)
    if rng.random() < 0.05:
        mixed = np.clip(mixed, -0.4 * peak, 0.4 * peak)
    return np.asarray(mixed, np.float32)


def _beeps(length: int, rng: Generator) -> Float:
    """A monitor or an alarm."""
    time = np.arange(length) / RATE
    period, share = rng.uniform(0.3, 1.5), rng.uniform(0.1, 0.5)
    tone = np.sin(2 * np.pi * rng.uniform(400, 3500) * time)
    return np.asarray(tone * (np.mod(time, period) < share * period), np.float32)


def _knocks(length: int, rng: Generator) -> Float:
    """Instruments put down, steps, doors."""
    sound = np.zeros(length, np.float32)
    for _ in range(int(rng.integers(2, 20))):
        decay = int(rng.uniform(0.005, 0.15) * RATE)
        knock = rng.standard_normal(decay) * np.exp(-6 * np.arange(decay) / decay)
        start = int(rng.integers(length - decay))
        sound[start : start + decay] += (rng.uniform(0.5, 3) * knock).astype(np.float32)
    return sound
