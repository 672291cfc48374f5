# SPDX-License-Identifier: BSD-3-Clause
"""Change sound so that synthesis and people, rooms and microphones look alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from numpy.random import Generator
from numpy.typing import NDArray
from torch import Tensor

from voice_assist.training.data.noise import ROOM, Float, Surroundings, background, coloured
from voice_assist.types import RATE


@dataclass(frozen=True)
class Strength:
    """How far and how often to change sound."""

    speed: tuple[float, float] = (0.85, 1.15)
    lead: tuple[float, float] = (0.02, 0.5)  # [s] of quiet before and after
    room: float = 0.35  # probability
    noise: float = 0.75  # probability of more than a faint background
    snr: tuple[float, float] = (0.0, 30.0)  # [dB]
    clip: float = 0.05  # probability
    warp: float = 0.10  # largest relative vocal-tract warp
    telephone: float = 0.0  # probability of a telephone line's band and mu-law steps


def resample_linear(samples: NDArray[np.int16], speed: float) -> Float:
    """Play samples at a relative speed; pitch and formants move along."""
    length = max(int(len(samples) / speed), 1)
    at = np.arange(length, dtype=np.float32) * np.float32(speed)
    return np.interp(at, np.arange(len(samples)), samples).astype(np.float32) / 32768


def place(sound: Float, length: int, offset: int) -> Float:
    """Put sound into silence of a given length."""
    placed = np.zeros(length, np.float32)
    kept = sound[: length - offset]
    placed[offset : offset + len(kept)] = kept
    return placed


def colour(batch: Tensor, around: Surroundings, how: Strength, rng: Generator) -> Tensor:
    """Rooms and microphone responses, all in one multiplication of spectra.

    Args:
        batch: Shape (batch, n).
        around: Rooms to draw from.
        how: Probabilities.
        rng: Source of chance.

    Returns:
        Shape (batch, n).
    """
    size = _fast_length(batch.shape[1] + ROOM)
    response = torch.zeros(len(batch), ROOM + 8)
    for row in response:
        row[0] = 1.0
        if rng.random() < how.room:
            room = around.rooms[int(rng.integers(len(around.rooms)))]
            row[: len(room)] = torch.from_numpy(room)
    curves = np.stack([_microphone(size // 2 + 1, rng) for _ in batch])
    spectrum = torch.fft.rfft(batch, size) * torch.fft.rfft(response, size)
    shaped = spectrum * torch.from_numpy(curves)
    return torch.fft.irfft(shaped, size)[:, : batch.shape[1]]


def add_background(batch: Tensor, around: Surroundings, how: Strength, rng: Generator) -> Tensor:
    """Noise under each item, then its level and now and then clipping.

    Silent items become noise only. Returns float32, shape as given.
    """
    sound = batch.numpy().copy()
    for row in sound:
        loud = row[np.abs(row) > 0.1 * np.abs(row).max()]
        level = np.sqrt(np.mean(loud**2)) if len(loud) else 0.0
        is_noisy = rng.random() < how.noise
        snr = rng.uniform(*how.snr) if is_noisy else rng.uniform(30, 60)
        level = level * 0.6 if level > 0 else 10 ** (rng.uniform(-80, -20) / 20)
        snr = snr if len(loud) else 0.0
        under = background(around, len(row), rng) if is_noisy or not len(loud) else None
        if under is None:
            under = coloured(len(row), 1.0, rng)
            under /= np.sqrt(np.mean(under**2)) + 1e-9
        row += under * (level * 10 ** (-snr / 20))
        peak = 10 ** (rng.uniform(-32, -0.5) / 20) if len(loud) else np.abs(row).max()
        row *= peak / (np.abs(row).max() + 1e-9)
        if rng.random() < how.clip:
            np.clip(row, -0.3 * peak, 0.3 * peak, out=row)
        if rng.random() < how.telephone:
            row[:] = telephone(row)
    return torch.from_numpy(sound)


def telephone(sound: Float) -> Float:
    """A line of 8 kHz, 300 to 3,400 Hz and 8 bits by the mu-law of ITU-T G.711.

    Args:
        sound: Within -1 to 1, 16 kHz. Shape (n,).

    Returns:
        Shape (n,), 16 kHz.
    """
    spectrum = np.fft.rfft(sound, _fast_length(len(sound)))
    frequency = np.linspace(0, RATE / 2, len(spectrum))
    spectrum[(frequency < 300) | (frequency > 3400)] = 0
    line = np.fft.irfft(spectrum)[: len(sound)].clip(-1, 1)
    steps = np.round(127 * np.log1p(255 * np.abs(line)) / np.log(256))
    return (np.sign(line) * np.expm1(steps / 127 * np.log(256)) / 255).astype(np.float32)


def warp_bands(mel: Tensor, how: Strength, rng: Generator) -> Tensor:
    """Stretch the frequency axis: other lengths of vocal tract.

    Args:
        mel: Shape (batch, bands, frames).
        how: Largest warp.
        rng: Source of chance.
    """
    bands = mel.shape[1]
    factor = rng.uniform(1 - how.warp, 1 + how.warp, (len(mel), 1))
    at = np.clip(np.arange(bands) * factor, 0, bands - 1).astype(np.float32)
    low = torch.from_numpy(np.minimum(at.astype(np.int64), bands - 2))
    part = torch.from_numpy(at).unsqueeze(-1) - low.unsqueeze(-1)
    index = low.unsqueeze(-1).expand(-1, -1, mel.shape[2])
    return mel.gather(1, index) * (1 - part) + mel.gather(1, index + 1) * part


def mask(mel: Tensor, rng: Generator) -> Tensor:
    """SpecAugment, gentle enough to leave short words whole; changes mel."""
    bands, frames = mel.shape[1:]
    for item in mel:
        fill = item.mean()
        for _ in range(rng.integers(0, 3)):
            width = int(rng.integers(0, 11))
            start = int(rng.integers(0, bands - width))
            item[start : start + width] = fill
        for _ in range(int(rng.integers(0, 2 + frames // 150))):
            width = int(rng.integers(0, min(8, frames // 10) + 1))
            start = int(rng.integers(0, frames - width))
            item[:, start : start + width] = fill
    return mel


def _microphone(bins: int, rng: Generator) -> Float:
    """A smooth random magnitude response with band limits."""
    frequency = np.linspace(0, RATE / 2, bins)
    knots = np.array([0, 150, 400, 1000, 2000, 4000, 8000])
    gain = np.interp(frequency, knots, rng.normal(0, 3.0, len(knots)))  # [dB]
    if rng.random() < 0.5:
        gain -= 24 * np.maximum(np.log2(rng.uniform(60, 350) / (frequency + 1)), 0)
    if rng.random() < 0.4:
        cut = rng.uniform(3200, 7500)
        gain -= 60 * np.maximum(np.log2((frequency + 1) / cut), 0)
    return (10 ** (np.maximum(gain, -80) / 20)).astype(np.float32)


def _fast_length(length: int) -> int:
    return -(-length // 2048) * 2048
