# SPDX-License-Identifier: BSD-3-Clause
"""Silero's speech detector, by the ONNX file inside its package."""

from __future__ import annotations

import numpy as np

from voice_assist.audio.source import FRAME
from voice_assist.networks import packaged_session
from voice_assist.types import RATE, Samples

_PACKAGE, _FILE = "silero_vad", "data/silero_vad_16k_op15.onnx"
_BEFORE = 64  # samples before a frame that the network looks at, too
_STATE = (2, 1, 128)


class SileroDetector:
    """Probability of speech by Silero's network; keeps a state from frame to frame."""

    def __init__(self) -> None:
        """Load the network.

        Raises:
            ModelError: The package with it is missing or damaged.
        """
        self._network = packaged_session(_PACKAGE, _FILE)
        self._rate = np.array(RATE, np.int64)
        self.reset()

    def reset(self) -> None:
        """Forget the stream so far."""
        self._state = np.zeros(_STATE, np.float32)
        self._before = np.zeros(_BEFORE, np.float32)

    def __call__(self, samples: Samples) -> float:
        """Probability of speech in the next frame.

        Raises:
            ValueError: The frame does not have 512 samples.
        """
        if len(samples) != FRAME:
            raise ValueError(f"frame of {len(samples)} samples, allowed: {FRAME}")
        sound = np.concatenate([self._before, samples.astype(np.float32, copy=False)])
        self._before = sound[-_BEFORE:]
        inputs = {"input": sound[None], "state": self._state, "sr": self._rate}
        probability, self._state = self._network.run(None, inputs)
        return float(probability[0, 0])
