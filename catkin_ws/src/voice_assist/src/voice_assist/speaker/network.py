# SPDX-License-Identifier: BSD-3-Clause
"""Speech to a point on a sphere that depends on the speaker, by the weights in `models/speaker.pt`.

The network is the speaker encoder of Wan et al. 2018, "Generalized End-to-End Loss for Speaker
Verification" (arXiv 1710.10467): three LSTM layers over mel bands. Its weights are resemblyzer's.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Final

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from typed_config import package_folder
from voice_assist.errors import ModelError
from voice_assist.recognizer.safe_weights import read_weights
from voice_assist.speaker.speech import piece_up
from voice_assist.types import RATE, Samples

Vector = NDArray[np.float64]

WIDTH: Final = 256  # of an embedding
PIECE: Final = 1.6  # [s] of speech that the network was trained on
LEVEL_DB: Final = -30.0  # [dB] of full scale, to which quieter speech is raised
_BATCH = 64
WEIGHTS: Final = package_folder("voice_assist") / "models" / "speaker.pt"
_SHA256: Final = "2772bb0547a44c177b0220352a130ac7fe31dc6f835bd6790c982963efb964a3"
_BANDS, _WINDOW, _HOP = 40, 400, 160
_KNEE, _STEP = 1000.0, 200.0 / 3.0  # [Hz] Slaney's scale: linear below, logarithmic above
_GROWTH = np.log(6.4) / 27.0  # of a band above the knee


class VoiceNetwork:
    """Embeds speech.

    Raises:
        ModelError: The weights are missing or others.
    """

    def __init__(self) -> None:
        state = _read_weights()
        self._lstm = nn.LSTM(_BANDS, WIDTH, 3, batch_first=True)
        self._linear = nn.Linear(WIDTH, WIDTH)
        for name, module in (("lstm", self._lstm), ("linear", self._linear)):
            own = {k.removeprefix(f"{name}."): v for k, v in state.items() if k.startswith(name)}
            module.load_state_dict(own)
            module.eval()
        self._filters = torch.from_numpy(_mel_filters().astype(np.float32))
        self._window = torch.hann_window(_WINDOW)

    def __call__(self, speech: Samples) -> Vector:
        """Direction of the speaker, of length 1. Shape (WIDTH,); see `many`."""
        direction: Vector = self.many([speech])[0]
        return direction

    def many(self, speeches: Sequence[Samples]) -> Vector:
        """Directions of several utterances, those of one length together, which is quicker.

        Speech longer than a piece is taken piece by piece. A shorter one is heard as it is and
        once more repeated up to a piece, which makes fewer errors on single words.

        Args:
            speeches: Without pauses, 16 kHz; each shape (n,), at least 0.1 s.

        Returns:
            Each of length 1. Shape (len(speeches), WIDTH).
        """
        whole, waiting = round(PIECE * RATE), defaultdict[int, list[tuple[int, Samples]]](list)
        for index, speech in enumerate(speeches):
            for piece in piece_up(speech, PIECE):
                loud = _raised(piece)
                waiting[len(loud)].append((index, loud))
                if len(loud) < whole:
                    waiting[whole].append((index, np.resize(loud, whole)))
        found = np.zeros((len(speeches), WIDTH))
        for group in waiting.values():
            for at in range(0, len(group), _BATCH):
                some = group[at : at + _BATCH]
                points = self._embed(np.stack([sound for _, sound in some])).numpy()
                np.add.at(found, [index for index, _ in some], points)
        return unit(found)

    @torch.inference_mode()
    def _embed(self, sounds: Samples) -> Tensor:
        """Points of length 1, (batch, WIDTH), of sounds (batch, n)."""
        stft = torch.stft(
            torch.from_numpy(sounds),
            _WINDOW,
            _HOP,
            window=self._window,
            pad_mode="constant",
            return_complex=True,
        )
        bands = (self._filters @ stft.abs().square()).transpose(1, 2)  # (batch, time, bands)
        _, (last, _) = self._lstm(bands)
        points: Tensor = self._linear(last[-1]).relu()
        return points / points.norm(dim=1, keepdim=True).clamp(min=1e-9)


def unit(vectors: Vector) -> Vector:
    """Vectors of shape (..., WIDTH), each made of length 1."""
    scaled: Vector = vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)
    return scaled


def _raised(sound: Samples) -> Samples:
    level = 20.0 * np.log10(float(np.sqrt(np.mean(np.square(sound)))) + 1e-9)
    gain = 10.0 ** (max(LEVEL_DB - level, 0.0) / 20.0)
    raised: Samples = (sound * gain).astype(np.float32)
    return raised


def _mel_filters() -> Vector:
    """Triangles of equal area on Slaney's scale (Auditory Toolbox, 1998). Shape (bands, bins)."""
    top = 15.0 + np.log(RATE / 2.0 / _KNEE) / _GROWTH
    scale = np.linspace(0.0, top, _BANDS + 2)
    edges = np.where(scale < 15.0, scale * _STEP, _KNEE * np.exp(_GROWTH * (scale - 15.0)))
    bins = np.linspace(0.0, RATE / 2.0, _WINDOW // 2 + 1)[None]
    low, middle, high = edges[:-2, None], edges[1:-1, None], edges[2:, None]
    slopes = np.minimum((bins - low) / (middle - low), (high - bins) / (high - middle))
    filters: Vector = np.maximum(slopes, 0.0) * 2.0 / (high - low)
    return filters


def _read_weights() -> dict[str, Tensor]:
    state, found = read_weights(WEIGHTS)
    if found != _SHA256 or not isinstance(state, dict):
        raise ModelError(f"{WEIGHTS} has the SHA-256 {found[:12]}, allowed: {_SHA256[:12]}")
    return state
