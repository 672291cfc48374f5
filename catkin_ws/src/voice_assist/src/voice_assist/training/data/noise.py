# SPDX-License-Identifier: BSD-3-Clause
"""Backgrounds and rooms that training sound is put into."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from voice_assist.types import RATE, Samples

Float = NDArray[np.float32]
ROOM = RATE // 2  # samples kept of a room response


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Recorded and computed noises and rooms; people and synthesis share them."""

    noises: Sequence[Float]  # each (n,), 16 kHz
    rooms: Sequence[Float]  # each (n,), direct sound first, unit energy
    talkers: Sequence[NDArray[np.int16]]  # speech to make babble of


def build_rooms(recorded: Sequence[Float], rng: Generator, count: int = 200) -> list[Float]:
    """Recorded room responses and computed exponential ones."""
    rooms = [_trim_room(room) for room in recorded]
    for _ in range(count):
        decay = rng.uniform(0.05, 0.6)  # [s] to -60 dB
        length = min(int(decay * RATE), ROOM)
        tail = rng.standard_normal(length) * 10 ** (-3 * np.arange(length) / length)
        tail[: rng.integers(16, 160)] = 0  # before the first reflection
        room = tail / (np.linalg.norm(tail) + 1e-9) * 10 ** (-rng.uniform(0, 15) / 20)
        room[0] = 1.0
        rooms.append((room / np.linalg.norm(room)).astype(np.float32))
    return rooms


def background(around: Surroundings, length: int, rng: Generator) -> Float:
    """Noise of unit power: recorded, coloured, hum, or several people talking.

    Args:
        around: What to draw from.
        length: Samples wanted.
        rng: Source of chance.

    Returns:
        Shape (length,).
    """
    kind = rng.random()
    if kind < 0.55 and around.noises:
        weights = np.array([min(len(noise), 60 * RATE) for noise in around.noises])
        noise = _cut(
            around.noises[int(rng.choice(len(weights), p=weights / weights.sum()))], length, rng
        )
    elif kind < 0.75 and around.talkers:
        noise = _babble(around.talkers, length, rng)
    elif kind < 0.95:
        noise = coloured(length, rng.uniform(0, 2), rng)
    else:
        noise = _hum(length, rng)
    return (noise / (np.sqrt(np.mean(noise**2)) + 1e-6)).astype(np.float32)


def coloured(length: int, slope: float, rng: Generator) -> Float:
    """Noise whose power falls as frequency to the -slope (0 white, 1 pink)."""
    spectrum = np.fft.rfft(rng.standard_normal(length))
    frequency = np.maximum(np.fft.rfftfreq(length, 1 / RATE), 30.0)
    return np.fft.irfft(spectrum * frequency ** (-slope / 2), length).astype(np.float32)


def _hum(length: int, rng: Generator) -> Float:
    time = np.arange(length) / RATE
    base = rng.choice([50.0, 60.0, 100.0, 120.0, rng.uniform(80, 1000)])
    tones = [
        rng.random() * np.sin(2 * np.pi * base * k * time + rng.uniform(0, 6.28))
        for k in range(1, 7)
    ]
    return np.sum(tones, axis=0) + 0.1 * coloured(length, 1.0, rng)


def _babble(talkers: Sequence[NDArray[np.int16]], length: int, rng: Generator) -> Float:
    mixed = np.zeros(length, np.float32)
    for _ in range(rng.integers(3, 7)):
        voice = talkers[int(rng.integers(len(talkers)))].astype(np.float32)
        voice = _cut(voice, length, rng)
        mixed += voice / (np.sqrt(np.mean(voice**2)) + 1.0)
    return mixed


def _cut(sound: Samples, length: int, rng: Generator) -> Float:
    """A random stretch, repeated where the sound is shorter."""
    if len(sound) < length:
        sound = np.tile(sound, length // max(len(sound), 1) + 1)
    start = rng.integers(len(sound) - length + 1)
    return sound[start : start + length]


def _trim_room(room: Float) -> Float:
    peak = int(np.abs(room).argmax())
    kept = room[max(peak - 8, 0) : peak + ROOM]
    return (kept / np.linalg.norm(kept)).astype(np.float32)
