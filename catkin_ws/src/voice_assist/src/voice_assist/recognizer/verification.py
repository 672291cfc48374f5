# SPDX-License-Identifier: BSD-3-Clause
"""Verifies a phrase in a sound: the phrase, or another word that the recogniser writes the same.

The network was trained to write seven commands, so its last layers make "tense" of a Spaniard's
"tenso". Its second block still has the difference. For each phrase a linear classifier reads the
states there, one mean for each letter along the CTC head's path and some around them.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from typed_config import package_folder
from voice_assist.errors import ModelError
from voice_assist.recognizer.ctc import Floats, best_alignment
from voice_assist.recognizer.safe_weights import check_weights, read_for_encoder, write_for_encoder
from voice_assist.recognizer.vocabulary import CHARACTERS, encode

PATH = package_folder("voice_assist") / "models" / "verifier.pt"
BLOCKS = 2  # of the encoder, below the states that are read
_REACH = 2  # states, 40 ms, that the first and the last letter have on their free side
_SAID = (-4, 5)  # states from the first and the last letter, which make the word
_TINY = 1e-6  # added to a spread, which may be none
_FLOOR = 0.1  # of the mean spread: least spread of one of a state's numbers
_AROUND = ((-6, -2), (1, 4), (4, 8), (8, 13))  # states from the first letter, then from the last


class PhraseVerifier:
    """One linear classifier for each phrase."""

    def __init__(self, weights: Mapping[str, NDArray[np.float32]]) -> None:
        """Take the weights.

        Args:
            weights: Of each phrase, its bias last. Shape ((letters + 4) * d + 1,).
        """
        self._weights = dict(weights)

    def __call__(self, hidden: Floats, ctc: Floats, phrase: str) -> float:
        """Log-odds [nat] that the sound is the phrase; infinity for a phrase that it cannot verify.

        Args:
            hidden: States after BLOCKS of the encoder. Shape (time, d).
            ctc: Log-probabilities of the CTC head. Shape (time, classes).
            phrase: Normalised text.
        """
        weights = self._weights.get(phrase)
        if weights is None:
            return float("inf")
        _, frames = best_alignment(ctc, np.array(encode(phrase)))
        return float(segments(hidden, frames) @ weights[:-1] + weights[-1])


def segments(hidden: Floats, frames: NDArray[np.int64]) -> Floats:
    """Means of states along the letters of a phrase and around them.

    States are taken relative to mean and spread within the word, so that voice, room and microphone
    matter less.

    Args:
        hidden: Shape (time, d).
        frames: State in which each letter is strongest, rising. Shape (letters,).

    Returns:
        Shape ((letters + 4) * d,).
    """
    first, last = int(frames[0]), int(frames[-1])
    word = hidden[max(first + _SAID[0], 0) : last + _SAID[1]]
    spread = word.std(axis=0)
    hidden = (hidden - word.mean(axis=0)) / (spread + _FLOOR * spread.mean() + _TINY)
    middles = (frames[:-1] + frames[1:] + 1) // 2
    edges = [first - _REACH, *map(int, middles), last + _REACH]
    before, *after = _AROUND
    spans = [*pairwise(edges), (first + before[0], first + before[1])]
    spans += [(last + begin, last + end) for begin, end in after]
    return np.concatenate([_mean(hidden, begin, end) for begin, end in spans])


def _mean(hidden: Floats, begin: int, end: int) -> Floats:
    """Mean of a span of states, cut to those there are; at least one."""
    start = min(max(begin, 0), len(hidden) - 1)
    mean: Floats = hidden[start : max(min(end, len(hidden)), start + 1)].mean(axis=0)
    return mean


def read_verifier(encoder_sha256: str, width: int, path: Path = PATH) -> PhraseVerifier | None:
    """Verifier of a file, by weights only; None: it was made for another recogniser.

    Args:
        encoder_sha256: Of the recogniser's checkpoint.
        width: Of its encoder's states.
        path: What write_verifier wrote.

    Raises:
        ModelError: The file is missing, damaged, or holds something else.
    """
    made_for, state, _ = read_for_encoder(path)
    if made_for != encoder_sha256:
        return None
    phrases = [p for p in state if isinstance(p, str)] if isinstance(state, dict) else []
    if odd := [p for p in phrases if not p or not set(p) <= set(CHARACTERS)]:
        raise ModelError(f"{path}: {odd[0]!r}, allowed: phrases in letters a to z")
    shapes = {p: ((len(p) + len(_AROUND)) * width + 1,) for p in phrases}
    checked = check_weights(f"verifier {path}", state, shapes)
    return PhraseVerifier({p: weights.float().numpy() for p, weights in checked.items()})


def write_verifier(
    weights: Mapping[str, NDArray[np.float32]], encoder_sha256: str, path: Path = PATH
) -> None:
    """Write the weights of each phrase, all or nothing."""
    state = {phrase: torch.from_numpy(values) for phrase, values in weights.items()}
    write_for_encoder(state, encoder_sha256, path)
