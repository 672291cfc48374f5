# SPDX-License-Identifier: BSD-3-Clause
"""Sound to embeddings by the frozen networks inside the package openwakeword, block by block.

The embedding is Google's `speech_embedding` (Lin et al. 2020, "Training Keyword Spotters with
Limited and Synthesized Speech Data", arXiv 2002.01322); the package holds it as ONNX files.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from voice_assist.networks import packaged_session
from voice_assist.types import RATE, Samples

STEP = 1280  # samples between two embeddings, 80 ms
WIDTH = 96  # of an embedding
OVERLAP = 480  # samples of the block before that the spectrogram needs
BANDS, LINES = 32, 76  # of the spectrogram under one embedding: 0.775 s
PACKAGE = "openwakeword"
SPECTROGRAM = "resources/models/melspectrogram.onnx"
EMBEDDING = "resources/models/embedding_model.onnx"

Embeddings = NDArray[np.float32]


class Embedder:
    """Follows a stream; one embedding for every `STEP` samples, whatever the blocks they come in.

    The spectrogram of each step is made of the same samples in every case, since the network
    clips it relative to the loudest of what it sees. Before its first sample the stream is taken
    to be silent, so that it is heard from that sample on.
    """

    def __init__(self) -> None:
        """Load the networks, one thread each.

        Raises:
            ModelError: The package with them is missing or damaged.
        """
        self._spectrogram = packaged_session(PACKAGE, SPECTROGRAM)
        self._embedding = packaged_session(PACKAGE, EMBEDDING)
        quiet = self.lines(np.zeros(STEP + OVERLAP, np.float32))
        self.quiet_lines = np.tile(quiet, (-(-LINES // len(quiet)), 1))[-LINES:]
        self.quiet: Embeddings = self._embed(self.quiet_lines)  # (WIDTH,) of silence
        self.reset()

    def reset(self) -> None:
        """Begin a new stream."""
        self._sound = np.zeros(OVERLAP, np.float32)
        self._seen = self.quiet_lines

    def __call__(self, samples: Samples) -> Iterator[Embeddings]:
        """Take the next samples, shape (n,), within [-1, 1]; gives embeddings, each (WIDTH,)."""
        self._sound = np.concatenate([self._sound, samples])
        while len(self._sound) >= STEP + OVERLAP:
            lines = self.lines(self._sound[: STEP + OVERLAP])
            self._sound = self._sound[STEP:]
            self._seen = np.concatenate([self._seen, lines])[-LINES:]
            yield self._embed(self._seen)

    def lines(self, sound: Samples) -> Embeddings:
        """Spectrogram scaled as the embedding expects it; shape (STEP / 160, bands)."""
        scaled = (sound * np.float32(32768.0))[None]
        (decibels,) = self._spectrogram.run(None, {"input": scaled})
        lines: Embeddings = decibels.reshape(-1, BANDS) / np.float32(10.0) + np.float32(2.0)
        return lines

    def _embed(self, lines: Embeddings) -> Embeddings:
        (embedding,) = self._embedding.run(None, {"input_1": lines[None, :, :, None]})
        flat: Embeddings = embedding.reshape(WIDTH)
        return flat


def seconds(step: int) -> float:
    """Stream time at which the embedding of a step, counted from 0, is complete [s]."""
    return (step + 1) * STEP / RATE
