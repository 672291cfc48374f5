# SPDX-License-Identifier: BSD-3-Clause
"""Whisper's log-mel spectrogram, for batches of short sound without padding."""

from __future__ import annotations

from functools import lru_cache

import torch
from torch import Tensor
from whisper.audio import HOP_LENGTH, N_FFT, mel_filters

SAMPLES_PER_STATE = 2 * HOP_LENGTH  # the encoder halves the spectrogram's frames; 20 ms


@lru_cache(maxsize=4)
def _tables(device: torch.device, n_mels: int) -> tuple[Tensor, Tensor]:
    window = torch.hann_window(N_FFT, device=device)
    return window, mel_filters(device, n_mels)


def log_mel(samples: Tensor, n_mels: int = 80) -> Tensor:
    """Spectrogram as Whisper computes it, item by item.

    Args:
        samples: float32 in [-1, 1], 16 kHz. Shape (batch, n), n >= 400.
        n_mels: Bands.

    Returns:
        Shape (batch, n_mels, n // 160).
    """
    window, filters = _tables(samples.device, n_mels)
    stft = torch.stft(samples, N_FFT, HOP_LENGTH, window=window, return_complex=True)
    power = torch.view_as_real(stft[..., :-1]).square().sum(-1)
    log = (filters @ power).clamp(min=1e-10).log10()
    log = torch.maximum(log, log.amax(dim=(1, 2), keepdim=True) - 8.0)
    return (log + 4.0) / 4.0
