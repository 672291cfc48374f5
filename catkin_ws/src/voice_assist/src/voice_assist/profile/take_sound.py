# SPDX-License-Identifier: BSD-3-Clause
"""The sound of a take as its file holds it: WAV of 16 bit, 16 kHz, mono."""

from __future__ import annotations

import io

import numpy as np
import soundfile

from voice_assist.types import FULL_SCALE, RATE, Samples, frozen_samples


def to_wav(samples: Samples) -> bytes:
    """The file of a sound in [-1, 1]. Shape (n,)."""
    scaled = np.rint(np.clip(samples, -1.0, 1.0) * FULL_SCALE).astype(np.int16)
    file = io.BytesIO()
    soundfile.write(file, scaled, RATE, format="WAV", subtype="PCM_16")
    return file.getvalue()


def from_wav(data: bytes) -> Samples:
    """The sound of a file. Shape (n,), read-only.

    Raises:
        ValueError: It is no recording, or one of another rate or of more channels.
    """
    try:
        samples, rate = soundfile.read(io.BytesIO(data), dtype="int16")
    except (soundfile.LibsndfileError, RuntimeError) as error:
        raise ValueError(str(error)) from error
    if rate != RATE or samples.ndim != 1:
        raise ValueError(f"{rate} Hz of shape {samples.shape}, allowed: {RATE} Hz mono")
    return frozen_samples(samples)
