# SPDX-License-Identifier: BSD-3-Clause
"""Speech of espeak-ng and the noise of an operating theatre."""

from __future__ import annotations

import numpy as np
import soxr
from numpy.typing import NDArray

from voice_assist.audio.espeak import espeak
from voice_assist.errors import ModelError

RATE = 16_000  # [Hz]
LEVEL = 0.08  # RMS of speech, full scale 1
LOUD = 0.02  # of full scale; quieter samples do not count for the level


def speak(words: str, voice: str, words_per_minute: int) -> NDArray[np.float32]:
    """Synthesise words with espeak-ng.

    Returns:
        Sound at 16 kHz with RMS `LEVEL` over its loud parts. Shape (n,).

    Raises:
        RuntimeError: espeak-ng is missing or refuses the voice.
    """
    try:
        sound, rate = espeak(words, voice, "-s", str(words_per_minute))
    except ModelError as error:
        raise RuntimeError(f"espeak-ng could not say {words!r} as {voice!r}: {error}") from error
    return levelled(soxr.resample(sound.astype(np.float32) / np.float32(32768), rate, RATE))


def levelled(samples: NDArray[np.float32]) -> NDArray[np.float32]:
    """Bring speech to the level of all speech in demo and paper.

    Args:
        samples: In [-1, 1]. Shape (n,).

    Returns:
        In [-1, 1], with RMS `LEVEL` over its loud parts; as it was where it has none. Shape (n,).
    """
    loud = samples[np.abs(samples) > LOUD]
    scale = LEVEL / np.sqrt(np.mean(loud**2)) if len(loud) else 1.0
    return np.clip(samples * scale, -1.0, 1.0).astype(np.float32)


def theatre_noise(seconds: float, rms: float, seed: int) -> NDArray[np.float32]:
    """Fans (pink noise), mains hum and a monitor that beeps every second.

    Args:
        seconds: Length [s].
        rms: Of the whole, full scale 1.
        seed: Of the random part.

    Returns:
        Sound at 16 kHz. Shape (n,).
    """
    n = int(seconds * RATE)
    t = np.arange(n) / RATE
    spectrum = np.fft.rfft(np.random.default_rng(seed).standard_normal(n))
    frequency = np.maximum(np.fft.rfftfreq(n, 1 / RATE), 20.0)
    fans = np.fft.irfft(spectrum / np.sqrt(frequency), n)
    hum = np.sin(2 * np.pi * 100 * t) + 0.5 * np.sin(2 * np.pi * 200 * t)
    beep = np.sin(2 * np.pi * 880 * t) * (np.mod(t, 1.0) < 0.12)
    noise = fans / np.std(fans) + 0.2 * hum + 0.3 * beep
    return (noise * (rms / np.sqrt(np.mean(noise**2)))).astype(np.float32)
