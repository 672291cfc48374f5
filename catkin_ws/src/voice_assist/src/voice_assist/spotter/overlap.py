# SPDX-License-Identifier: BSD-3-Clause
"""Hears "stop" while others talk: the recogniser's encoder over the newest 1.6 s, every 80 ms.

A second way beside `head`: it has neither that way's network nor its embeddings. Endpointing does
not matter to it. `Spotter` follows the stream and fires; this module gives it windows and scores.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from whisper.model import AudioEncoder, ModelDimensions

from typed_config import package_folder
from voice_assist.errors import ModelError
from voice_assist.recognizer.checkpoint import EMBEDDED_PATH, Checkpoint, read_checkpoint
from voice_assist.recognizer.hybrid import encode_short
from voice_assist.recognizer.mel import log_mel
from voice_assist.recognizer.safe_weights import check_weights, read_for_encoder, write_for_encoder
from voice_assist.types import RATE, Samples

PATH = package_folder("voice_assist") / "models" / "overlap.pt"
STEP = 1280  # samples between two windows, 80 ms
WINDOW = 25_600  # samples of a window, 1.6 s
TRAINED = 2  # blocks of the encoder, the last ones, that have weights of their own
STEADY = -20.0  # [nat] the score of steady sound
_HOP = 3 * STEP  # between two windows of an utterance, 0.24 s
_NEWEST = 4  # windows: a word that ended up to 1.1 s ago
_FRAME, _STANDS_OUT = 320, 2.0  # samples; ratio of powers
_WIDE, _NARROW, _REACH = 128, 64, 5  # channels and width of the convolutions

Windows = NDArray[np.float32]
WindowNetwork = Callable[[Tensor], tuple[Tensor, Tensor]]  # as `OverlapNetwork`


class OverlapNetwork(nn.Module):
    """Log-odds that the word ended within the last 0.4 s of a window.

    Each 20 ms of the window has a value, and a weight that says whether the word is there.
    """

    def __init__(self, dims: ModelDimensions) -> None:
        """Start with random weights.

        Args:
            dims: Of the recogniser, whose encoder it takes.
        """
        super().__init__()
        sizes = (dims.n_mels, dims.n_audio_ctx, dims.n_audio_state)
        self.encoder = AudioEncoder(*sizes, dims.n_audio_head, dims.n_audio_layer)
        self.head = nn.Sequential(
            nn.Conv1d(dims.n_audio_state, _WIDE, _REACH, padding=_REACH // 2),
            nn.GELU(),
            nn.Conv1d(_WIDE, _NARROW, _REACH, padding=_REACH // 2),
            nn.GELU(),
            nn.Conv1d(_NARROW, 2, _REACH, padding=_REACH // 2),
        )

    def forward(self, sound: Tensor) -> tuple[Tensor, Tensor]:
        """Opinion on windows.

        Args:
            sound: Within [-1, 1], 16 kHz. Shape (batch, WINDOW).

        Returns:
            Log-odds [nat] of shape (batch,), and of the word in each 20 ms, (batch, WINDOW / 320).
        """
        return self.judge(encode_short(self.encoder, log_mel(sound)))

    def judge(self, states: Tensor) -> tuple[Tensor, Tensor]:
        """The same from the encoder's states, shape (batch, time, d)."""
        value, there = self.head(states.transpose(1, 2)).float().unbind(1)
        return (there.softmax(-1) * value).sum(-1), there

    def own_state(self) -> dict[str, Tensor]:
        """Weights that are not the recogniser's."""
        first = len(self.encoder.blocks) - TRAINED
        own = (*(f"encoder.blocks.{first + i}." for i in range(TRAINED)), "encoder.ln_post.")
        return {
            name: weight
            for name, weight in self.state_dict().items()
            if name.startswith((*own, "head."))
        }


class WindowCutter:
    """Follows a stream; the newest 1.6 s of it after every `STEP` samples, whatever the blocks.

    Before its first sample the stream is taken to be silent.
    """

    def __init__(self) -> None:
        """Begin a stream."""
        self.quiet: Windows = np.zeros(WINDOW, np.float32)
        self.reset()

    def reset(self) -> None:
        """Begin a new stream."""
        self._sound = np.zeros(WINDOW - STEP, np.float32)

    def __call__(self, samples: Samples) -> Iterator[Windows]:
        """Take the next samples, shape (n,), within [-1, 1]; gives windows, each (WINDOW,)."""
        self._sound = np.concatenate([self._sound, samples.astype(np.float32, copy=False)])
        while len(self._sound) >= WINDOW:
            window, self._sound = self._sound[:WINDOW], self._sound[STEP:]
            yield window


def untrained(checkpoint: Checkpoint) -> OverlapNetwork:
    """A network with the recogniser's encoder and a random head."""
    network = OverlapNetwork(checkpoint.dims)
    network.encoder.load_state_dict(
        {
            name.removeprefix("encoder."): weight.float()
            for name, weight in checkpoint.state.items()
            if name.startswith("encoder.")
        }
    )
    return network


def read_overlap(path: Path = PATH, encoder: Path = EMBEDDED_PATH) -> tuple[OverlapNetwork, str]:
    """Network of a file, by weights only, and the SHA-256 of the file.

    Args:
        path: What `write_overlap` wrote.
        encoder: The recogniser whose encoder it was trained on.

    Raises:
        ModelError: A file is missing, damaged, or holds something else, or they are no pair.
    """
    made_for, own_state, digest = read_for_encoder(path)
    checkpoint = read_checkpoint(encoder)
    if made_for != checkpoint.sha256:
        allowed = f"allowed: {checkpoint.sha256[:12]}, which is {encoder}"
        raise ModelError(f"{path} belongs to the encoder {made_for:.12}, {allowed}")
    network = untrained(checkpoint)
    shapes = {name: tuple(weight.shape) for name, weight in network.own_state().items()}
    state = check_weights(f"spotter model {path}", own_state, shapes)
    network.load_state_dict({n: w.float() for n, w in state.items()}, strict=False)
    return network.eval(), digest


def write_overlap(network: OverlapNetwork, encoder_sha256: str, path: Path) -> None:
    """Write the weights that are not the recogniser's, in half precision, all or nothing."""
    state = {name: weight.detach().half() for name, weight in network.own_state().items()}
    write_for_encoder(state, encoder_sha256, path)


def is_steady(window: Windows) -> bool:
    """Whether nothing stands out of a window, shape (..., WINDOW): no 20 ms is 3 dB over the floor.

    The floor is the power that a fifth of them stay below. In white noise the loudest 20 ms are
    1 dB above it; a word as loud as the noise is 4 dB above it. A constant offset is no sound.
    """
    power = np.square((window - window.mean()).reshape(-1, _FRAME)).mean(axis=1)
    return float(power.max()) <= _STANDS_OUT * float(np.quantile(power, 0.2))


def overlap_scorer(network: WindowNetwork) -> Callable[[Windows], float]:
    """Log-odds [nat] of a window, shape (1, WINDOW); steady sound costs no pass of the network."""

    def score(window: Windows) -> float:
        if is_steady(window):
            return STEADY
        with torch.inference_mode():
            return float(network(torch.from_numpy(window))[0])

    return score


class SoundScorer:
    """The network for the sound of an utterance that grows; asks about each part of it once.

    Its windows end 0.24 s apart, and where it is asked. Before the sound there is silence.
    """

    def __init__(self, network: WindowNetwork) -> None:
        """Ask that network."""
        self._network = network
        self.restart()

    def restart(self) -> None:
        """What follows is another sound."""
        self._best, self._until, self._asked_until = STEADY, 0, 0

    def follow(self, sound: Samples) -> None:
        """Take the sound so far, shape (n,); the windows that have become whole are asked about."""
        if ends := range(self._until + _HOP, len(sound) + 1, _HOP):
            self._until = ends[-1]
            self._ask(sound, ends)

    def best(self, sound: Samples, quiet: float) -> float:
        """The best log-odds [nat] of all windows of the sound so far, and of one in its last quiet.

        Args:
            sound: Shape (n,).
            quiet: At its end, in which nothing was said [s]; 0: the last window ends with it.
        """
        self.follow(sound)
        if self._asked_until < max(len(sound) - quiet * RATE, 1):
            self._ask(sound, (len(sound),))
        return self._best

    def newest(self, sound: Samples) -> float:
        """The best log-odds [nat] of a word that ended in the newest 1.1 s of a sound."""
        return self._score(sound, range(len(sound), 0, -_HOP)[:_NEWEST] or (0,))

    def _ask(self, sound: Samples, ends: Sequence[int]) -> None:
        self._best, self._asked_until = max(self._best, self._score(sound, ends)), ends[-1]

    def _score(self, sound: Samples, ends: Sequence[int]) -> float:
        padded = np.concatenate([np.zeros(WINDOW, np.float32), sound.astype(np.float32)])
        windows = np.stack([padded[end : end + WINDOW] for end in ends])
        with torch.inference_mode():
            return float(self._network(torch.from_numpy(windows))[0].max())
