# SPDX-License-Identifier: BSD-3-Clause
"""Any sample rate and any number of channels to 16 kHz mono."""

from __future__ import annotations

import numpy as np
import soxr
from numpy.typing import NDArray

from voice_assist.audio.channels import StreamMixer
from voice_assist.errors import AudioError
from voice_assist.types import RATE, Samples

MIN_RATE, MAX_RATE = 1000, 768_000  # [Hz] of any sound device or file


def rate_objection(rate: int) -> str:
    """Why a sample rate [Hz] is none of sound; empty: it is."""
    allowed = f"allowed: {MIN_RATE} to {MAX_RATE} Hz"
    return "" if MIN_RATE <= rate <= MAX_RATE else f"sample rate {rate} Hz, {allowed}"


class Resampler:
    """Resamples a stream block by block, without clicks between them."""

    def __init__(self, rate: int) -> None:
        """Start a stream.

        Args:
            rate: Of the blocks to come [Hz].

        Raises:
            AudioError: The rate is none of a sound device or file.
        """
        if words := rate_objection(rate):
            raise AudioError(words)
        self._mix = StreamMixer(rate)
        self._stream = None if rate == RATE else soxr.ResampleStream(rate, RATE, 1, "float32")

    @property
    def remark(self) -> str:
        """What a person should know of the channels; empty: nothing."""
        return self._mix.remark

    def __call__(self, samples: NDArray[np.generic], is_last: bool = False) -> Samples:
        """Resample one block.

        Args:
            samples: Float in [-1, 1] or int16. Shape (n,) or (n, channels).
            is_last: Nothing follows: give all that is still inside.

        Returns:
            As many samples as are ready, 16 kHz. Shape (m,).
        """
        mono = self._mix(samples)
        if self._stream is None:
            return mono
        return np.asarray(self._stream.resample_chunk(mono, last=is_last), np.float32)
