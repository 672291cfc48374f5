# SPDX-License-Identifier: BSD-3-Clause
"""The spotter's embeddings of a whole recording, three times as fast as step by step."""

from __future__ import annotations

import struct

import numpy as np

from voice_assist.errors import ModelError
from voice_assist.networks import onnx_session, read_network
from voice_assist.spotter.features import (
    BANDS,
    EMBEDDING,
    LINES,
    OVERLAP,
    PACKAGE,
    STEP,
    WIDTH,
    Embedder,
    Embeddings,
)
from voice_assist.types import Samples

_PER_STEP = 8  # lines of the spectrogram
_AT_ONCE = 7  # embeddings; 124 lines are the most that fit the one byte of their number


class LongEmbedder:
    """The same network fed with longer spectrograms.

    It is convolutional without padding in time, but its file fixes the length in two places; with
    another length written there it gives the embeddings of several steps at once, exactly those
    that it would give one by one.
    """

    def __init__(self) -> None:
        """Load the networks.

        Raises:
            ModelError: They are missing, or not the ones that this was written for.
        """
        self._step = Embedder()
        self._embedding = onnx_session(_lengthened(read_network(PACKAGE, EMBEDDING)))

    @property
    def quiet(self) -> Embeddings:
        """Embedding of silence, shape (WIDTH,)."""
        return self._step.quiet

    def __call__(self, samples: Samples) -> Embeddings:
        """Embeddings of a stream from its beginning, shape (len(samples) // STEP, WIDTH)."""
        count = len(samples) // STEP
        sound = np.concatenate([np.zeros(OVERLAP, np.float32), samples])
        lines = [self._step.quiet_lines]
        for at in range(0, count * STEP, STEP):
            lines.append(self._step.lines(sound[at : at + STEP + OVERLAP]))
        spare = np.zeros((_AT_ONCE * _PER_STEP, BANDS), np.float32)
        all_lines = np.concatenate([*lines, spare])[_PER_STEP:]
        found = [
            self._embed(all_lines[first * _PER_STEP :][: LINES + (_AT_ONCE - 1) * _PER_STEP])
            for first in range(0, count, _AT_ONCE)
        ]
        return np.concatenate([np.zeros((0, WIDTH), np.float32), *found])[:count]

    def _embed(self, lines: Embeddings) -> Embeddings:
        (found,) = self._embedding.run(None, {"input_1": lines[None, :, :, None]})
        steps: Embeddings = found.reshape(WIDTH, _AT_ONCE).T  # its last reshape swaps the two
        return steps


def _lengthened(network: bytes) -> bytes:
    """The file with the length for several steps, in its input's shape and in a reshape."""
    length = LINES + (_AT_ONCE - 1) * _PER_STEP
    shape = b"\x0a\x02\x08%c\x0a\x02\x08%c\x0a\x02\x08\x01"
    reshape = struct.Struct("<4q")
    for old, new in (
        (shape % (LINES, BANDS), shape % (length, BANDS)),
        (reshape.pack(-1, 1, LINES, BANDS + 2), reshape.pack(-1, 1, length, BANDS + 2)),
    ):
        if network.count(old) != 1:
            raise ModelError(f"{EMBEDDING} is not that of openwakeword 0.4.0")
        network = network.replace(old, new)
    return network
