# SPDX-License-Identifier: BSD-3-Clause
"""Silero's speech detector; imported late, because its package changes torch's threads."""

from __future__ import annotations

from typing import Any

import torch

from voice_assist.audio.source import FRAME
from voice_assist.errors import ModelError
from voice_assist.types import RATE, Samples


class SileroDetector:
    """Probability of speech by Silero's network; keeps a state from frame to frame."""

    def __init__(self) -> None:
        """Load the network, which comes inside its package, and leave torch as it was.

        Raises:
            ModelError: The package is damaged.
        """
        threads = torch.get_num_threads()
        try:
            from silero_vad import load_silero_vad

            self._model: Any = load_silero_vad()
        except (ImportError, OSError, RuntimeError) as error:
            raise ModelError(f"the Silero speech detector cannot be loaded: {error}") from error
        finally:
            torch.set_num_threads(threads)
        self.reset()

    def reset(self) -> None:
        """Forget the stream so far."""
        self._model.reset_states()

    def __call__(self, samples: Samples) -> float:
        """Probability of speech in the next frame.

        Raises:
            ValueError: The frame does not have 512 samples.
        """
        if len(samples) != FRAME:
            raise ValueError(f"frame of {len(samples)} samples, allowed: {FRAME}")
        with torch.inference_mode():
            return float(self._model(torch.tensor(samples), RATE))
