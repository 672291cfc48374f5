# SPDX-License-Identifier: BSD-3-Clause
"""What a spoken "stop" came to, from the end of the word's sound on: pure, so it can be wrong."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.signal import correlate

from support.figures import Figure, percentiles, share
from voice_assist.audio.mixing import end_of_speech
from voice_assist.types import RATE, Samples


@dataclass(frozen=True)
class SoundPiece:
    """Sound as it was sent."""

    stamp: float  # [s] of its first sample
    samples: Samples


@dataclass(frozen=True)
class SpokenStop:
    """One "stop", said while the robot moved."""

    who: str  # synthetic or human
    path: str  # of the sound
    received: float | None  # [s] from the word's end until the controller had a stop; None: never
    is_moving: bool  # when it came; otherwise the motion was over by itself
    setpoints: float  # [s] from the word's end until they rested; 0: before; inf: they went on
    joints: float  # [s] the same, of arm and jaws as the robot reports them


def end_of_word(pieces: Sequence[SoundPiece], clip: Samples) -> float:
    """When the speech of a clip that was sent ended [s], by the stamp of the piece it ends in.

    Its end is looked for in the clip alone: where that has a background of its own, the end of this
    would be the end of the word, seen from a room that is quieter still.

    Args:
        pieces: That hold the clip, from before it on, in order.
        clip: As it was spoken. Shape (n,).

    Raises:
        ValueError: There is no piece.
    """
    if not pieces:
        raise ValueError("no sound, of which one piece at least is needed")
    sound = np.concatenate([piece.samples for piece in pieces])
    word = clip[: round(end_of_speech(clip) * RATE)]
    sound = np.pad(sound, (0, len(word)))  # it may not have been sent whole
    end = int(np.argmax(correlate(sound, word, mode="valid"))) + len(word)
    for piece in pieces[:-1]:
        if end <= len(piece.samples):
            return piece.stamp + end / RATE
        end -= len(piece.samples)
    return pieces[-1].stamp + end / RATE


def figures(stops: Sequence[SpokenStop]) -> list[Figure]:
    """How many were heard, and how long the robot took to rest; each kind of voice apart."""
    found: list[Figure] = []
    for who in sorted({stop.who for stop in stops}):
        found += _of(f'"stop", {who}', [stop for stop in stops if stop.who == who])
    return found


def _of(name: str, stops: Sequence[SpokenStop]) -> list[Figure]:
    heard = [stop for stop in stops if stop.received is not None]
    missed = ", ".join(Path(stop.path).name for stop in stops if stop.received is None)
    note = missed and f"missed: {missed}"
    found = [share(f"{name}: heard", len(heard), len(stops), note=note)]
    moving = [stop for stop in heard if stop.is_moving]
    found.append(Figure(f"{name}: came in motion", len(moving), "", note=f"(of {len(heard)})"))
    rested = [stop for stop in moving if np.isfinite([stop.setpoints, stop.joints]).all()]
    restless = len(moving) - len(rested)
    found.append(Figure(f"{name}: came in motion, and it went on", restless, "", 0.0))
    if rested:
        received = [1e3 * stop.received for stop in rested if stop.received is not None]
        setpoints = [1e3 * stop.setpoints for stop in rested]
        joints = [1e3 * stop.joints for stop in rested]
        what = f"{name}: end of the word to"
        found += percentiles(f"{what} stop received", received, "ms")
        found += percentiles(f"{what} set-points at rest", setpoints, "ms")
        found += percentiles(f"{what} arm and jaws at rest", joints, "ms")
    return found
