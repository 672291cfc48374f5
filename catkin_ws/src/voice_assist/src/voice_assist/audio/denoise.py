# SPDX-License-Identifier: BSD-3-Clause
"""Noise reduction for a stream: a high-pass filter and spectral gating, both with an off switch.

Gating follows Boll (1979), "Suppression of acoustic noise in speech using spectral subtraction",
with a gain between a floor and one in place of the difference, which leaves less musical noise.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from voice_assist.config import DenoiseConfig
from voice_assist.types import RATE, Samples

_WINDOW = 512  # samples, 32 ms
_HOP = 256
_NOISE_FALL = 0.03  # share of the way down to a quieter band that the noise floor goes per hop
_DROP = 0.1  # power over the noise floor below which the noise has ended, not only varied
_DROP_FALL = 0.3  # the same share then: what is said into the quiet after it must pass
_POWER_SMOOTHING = 0.7  # of each band from hop to hop
_GAIN_SMOOTHING = 0.5
_START_HOPS = 10  # the noise floor is simply the mean of so many first hops
_QUIETEST = 1e-9  # power of a band below which all is silence


class HighPass:
    """Removes rumble below a frequency; a Butterworth filter of second order.

    By the bilinear transform (Oppenheim and Schafer, Discrete-Time Signal Processing, 7.1). It is
    linear, so a block of samples is filtered by one product of matrices. scipy.signal does the
    same, but its import is a third of the voice node's start.
    """

    def __init__(self, cutoff: float) -> None:
        """Start with silence behind.

        Args:
            cutoff: -3 dB frequency [Hz]; 0 lets everything pass.
        """
        self._passes_all = not cutoff
        if self._passes_all:
            return
        k = np.tan(np.pi * cutoff / RATE)
        a0 = 1.0 + np.sqrt(2.0) * k + k * k
        a1, a2 = 2.0 * (k * k - 1.0) / a0, (1.0 - np.sqrt(2.0) * k + k * k) / a0
        A = np.array([[-a1, -a2], [1.0, 0.0]])  # of the last two values of 1 / denominator
        powers = [np.eye(2)]
        for _ in range(_HOP):
            powers.append(A @ powers[-1])
        self._powers = np.array(powers)  # (_HOP + 1, 2, 2)
        response = self._powers[:, 0, 0]  # of 1 / denominator
        lag = np.subtract.outer(np.arange(_HOP), np.arange(_HOP))
        self._inner = np.where(lag >= 0, response[np.maximum(lag, 0)], 0.0)
        self._gain = 1.0 / a0
        self._state = np.zeros(2)

    def __call__(self, samples: Samples) -> Samples:
        """Filter the next block, shape (n,)."""
        if self._passes_all:
            return samples
        pieces = [self._block(samples[i : i + _HOP]) for i in range(0, len(samples), _HOP)]
        return np.concatenate(pieces).astype(np.float32) if pieces else samples

    def _block(self, samples: Samples) -> NDArray[np.float64]:
        """Filter at most _HOP samples: 1 / denominator first, then the zeros at 0 Hz."""
        n, before = len(samples), self._state
        inner = self._inner[:n, :n] @ samples + self._powers[1 : n + 1, 0] @ before
        whole = np.concatenate([before[::-1], inner])
        self._state = whole[:-3:-1].copy()
        return self._gain * (whole[2:] - 2.0 * whole[1:-1] + whole[:-2])


class SpectralGate:
    """Turns down the bands of the spectrum that hold no more than the room's noise."""

    delay = _WINDOW - _HOP  # samples that the output is behind the input

    def __init__(self, reduction_db: float, margin_db: float, noise_rise: float) -> None:
        """Start with silence behind.

        Args:
            reduction_db: Most that noise is turned down [dB].
            margin_db: Above the noise floor from which a band passes unchanged [dB].
            noise_rise: Fastest rise of the noise floor [dB/s].
        """
        self._floor = 10.0 ** (-reduction_db / 20.0)
        self._margin = 10.0 ** (margin_db / 10.0)
        self._rise = 10.0 ** (noise_rise * _HOP / RATE / 10.0)
        self._window = np.sqrt(np.hanning(_WINDOW + 1)[:-1])  # squares add up to one at this hop
        bands = _WINDOW // 2 + 1
        self._input = np.zeros(_WINDOW)
        self._tail = np.zeros(_WINDOW)
        self._power: NDArray[np.float64] = np.zeros(bands)
        self._noise: NDArray[np.float64] = np.zeros(bands)
        self._gain: NDArray[np.float64] = np.ones(bands)
        self._hops = 0

    def __call__(self, samples: Samples) -> Samples:
        """Clean the next block; its length is a multiple of 256. Shape (n,), `delay` late."""
        if len(samples) % _HOP:
            raise ValueError(f"block of {len(samples)} samples, allowed: multiples of {_HOP}")
        hops = [self._hop(samples[i : i + _HOP]) for i in range(0, len(samples), _HOP)]
        return np.concatenate(hops).astype(np.float32) if hops else samples

    def _hop(self, samples: Samples) -> NDArray[np.float64]:
        self._input = np.concatenate([self._input[_HOP:], samples])
        spectrum = np.fft.rfft(self._input * self._window)
        self._follow(np.square(np.abs(spectrum)))
        wanted = np.clip(self._power / (self._noise * self._margin + _QUIETEST), self._floor, 1.0)
        # opens at once, so that no consonant is cut, and closes slowly
        slow = _GAIN_SMOOTHING * self._gain + (1.0 - _GAIN_SMOOTHING) * wanted
        self._gain = np.maximum(wanted, slow)
        cleaned = np.fft.irfft(spectrum * self._gain) * self._window
        self._tail = np.concatenate([self._tail[_HOP:], np.zeros(_HOP)]) + cleaned
        return self._tail[:_HOP].copy()

    def _follow(self, power: NDArray[np.float64]) -> None:
        """Update the smoothed power and the noise floor of each band."""
        self._power = _POWER_SMOOTHING * self._power + (1.0 - _POWER_SMOOTHING) * power
        self._hops += 1
        if self._hops <= _START_HOPS:
            self._noise += (power - self._noise) / self._hops
            return
        fall = np.where(self._power < _DROP * self._noise, _DROP_FALL, _NOISE_FALL)
        lower = self._noise + fall * (self._power - self._noise)
        higher = np.minimum(np.maximum(self._noise, _QUIETEST) * self._rise, self._power)
        self._noise = np.where(self._power < self._noise, lower, higher)


class Denoiser:
    """High-pass filter and spectral gate in a row, as the settings say."""

    def __init__(self, config: DenoiseConfig) -> None:
        """Start with silence behind."""
        self._config = config
        self.reset()

    def reset(self) -> None:
        """Forget the stream so far."""
        config = self._config
        self._filter = HighPass(config.high_pass)
        self._gate = SpectralGate(config.reduction_db, config.margin_db, config.noise_rise)

    def __call__(self, samples: Samples) -> Samples:
        """Clean the next block, shape (n,); unchanged where switched off."""
        if self._config.mode == "off":
            return samples
        return self._gate(self._filter(samples))
