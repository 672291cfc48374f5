# SPDX-License-Identifier: BSD-3-Clause
"""Separates tones, such as those of alarms, from voices: a tone keeps its pitch, no larynx can.

Alarms after IEC 60601-1-8 are bursts of notes with four harmonics and more, in the range of voices,
and two notes can pass for two words.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from voice_assist.types import RATE, Samples

STEP = 0.032  # [s] over which a partial's movement is taken
_SIZE = 1024  # samples of one spectrum, two steps
_PAD = 4  # times as many points in the spectrum
_LOWEST, _HIGHEST = 80.0, 4000.0  # [Hz] of the partials followed
_PARTIALS = 3  # strongest of each spectrum
_FAINT = 0.1  # of the strongest partial's amplitude: less is a side lobe of it, or noise
_LOUD = 0.1  # of the loudest spectrum's power: less is left out
_CENTS = 1200.0  # per octave
_FAR = 200.0  # [cent] or more is another note
_MIN_MOVES = 3  # movements that a median needs


def pitch_variation(samples: Samples) -> float:
    """How far the strongest partials move within a step, at the median of the loud ones.

    A tone's partials move by less than 1 cent, in noise 10 dB below it by less than 2; those of
    voices by 20 to 160. Frequencies are peaks of the log-spectrum, interpolated by a parabola.

    Args:
        samples: Sound, shape (n,).

    Returns:
        [cent] per STEP; infinite where there is too little sound.
    """
    hop = round(STEP * RATE)
    if len(samples) < _SIZE:
        return float("inf")
    windows = np.lib.stride_tricks.sliding_window_view(samples.astype(np.float64), _SIZE)[::hop]
    spectra = np.abs(np.fft.rfft(windows * np.hanning(_SIZE), _PAD * _SIZE))
    pitch = np.fft.rfftfreq(_PAD * _SIZE, 1.0 / RATE)
    spectra[:, (pitch < _LOWEST) | (pitch > _HIGHEST)] = 0.0
    power = np.sum(spectra**2, axis=1)
    is_loud = power > _LOUD * np.max(power)
    partials = [_partials(one) for one in spectra]
    moves = [
        _move(partials[i], partials[i + 1])
        for i in range(len(partials) - 1)
        if is_loud[i] and is_loud[i + 1]
    ]
    return float(np.median(moves)) if len(moves) >= _MIN_MOVES else float("inf")


def _partials(spectrum: NDArray[np.float64]) -> NDArray[np.float64]:
    """Frequencies [Hz] and amplitudes of the strongest, shape (up to _PARTIALS, 2)."""
    left, found = spectrum.copy(), []
    for _ in range(_PARTIALS):
        peak = int(np.argmax(left))
        if left[peak] < _FAINT * np.max(spectrum):
            break
        before, at, after = spectrum[peak - 1 : peak + 2] if peak else (0.0, 0.0, 0.0)
        left[max(0, peak - 2 * _PAD) : peak + 2 * _PAD + 1] = 0.0
        if min(before, at, after) <= 0.0:
            continue
        a, b, c = np.log((before, at, after))
        bend = a - 2.0 * b + c
        offset = float(np.clip(0.5 * (a - c) / bend, -0.5, 0.5)) if bend < 0.0 else 0.0
        found.append(((peak + offset) * RATE / (_PAD * _SIZE), at))
    return np.array(found).reshape(-1, 2)


def _move(before: NDArray[np.float64], after: NDArray[np.float64]) -> float:
    """Mean distance of partials to the nearest of the next step, by amplitude [cent]."""
    if not (len(before) and len(after)):
        return _FAR
    apart = _CENTS * np.abs(np.log2(before[:, None, 0] / after[None, :, 0]))
    nearest = np.minimum(np.min(apart, axis=1), _FAR)
    return float(np.average(nearest, weights=before[:, 1]))
