# SPDX-License-Identifier: BSD-3-Clause
"""Background voices: embeddings of many speakers, no sound, by which scores become comparable."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from io import BytesIO
from pathlib import Path

import numpy as np

from typed_config import package_folder
from voice_assist.errors import ModelError
from voice_assist.speaker.network import WIDTH, Vector, unit

PATH = package_folder("voice_assist") / "models" / "speaker_cohort.npz"
NEAREST = 100  # speakers by whose scores one is scaled: those most like it


@dataclass(frozen=True, eq=False)
class Cohort:
    """Speakers with a few short utterances each."""

    pieces: Vector  # (speakers, utterances, WIDTH), each of length 1

    @cached_property
    def speakers(self) -> Vector:
        """Each one's mean direction, of length 1. Shape (speakers, WIDTH)."""
        return unit(self.pieces.mean(axis=1))

    def score(self, heard: Vector, centres: Vector, without: int | None = None) -> Vector:
        """How much more an utterance is like a voice than like others [standard deviations].

        The cosine to the voice, less the mean of the cosines to the NEAREST background speakers,
        over their standard deviation: adaptive test normalisation (Auckenthaler et al. 2000, "Score
        Normalization for Text-Independent Speaker Verification Systems"; Sturim and Reynolds 2005).

        Args:
            heard: Of the utterance. Shape (WIDTH,).
            centres: Of one voice or of several. Shape (..., WIDTH).
            without: Speaker of the background that is not to be compared; None: all are.

        Returns:
            Shape (...,).
        """
        cosines = self.speakers @ heard
        if without is not None:
            cosines = np.delete(cosines, without)
        near = np.sort(cosines)[-NEAREST:]
        return np.asarray((centres @ heard - near.mean()) / max(float(near.std()), 1e-6))

    def impostors(self, centre: Vector) -> Vector:
        """Scores against a voice of all utterances of the NEAREST background speakers.

        They are those most like it: a person beside the surgeon may be of the same sex and sound
        alike, and speaks into the same microphone.

        Args:
            centre: Of the voice. Shape (WIDTH,).

        Returns:
            Shape (NEAREST * utterances,).
        """
        alike = np.argsort(self.speakers @ centre)[-NEAREST:]
        scores = [
            self.score(heard, centre, speaker)
            for speaker in alike
            for heard in self.pieces[speaker]
        ]
        return np.array(scores)


def read_cohort(path: Path = PATH) -> tuple[Cohort, str]:
    """The shipped background, and the SHA-256 of its file.

    Raises:
        ModelError: It is missing, damaged, or not what it should be.
    """
    try:
        data = path.read_bytes()
        with np.load(BytesIO(data), allow_pickle=False) as file:
            pieces = np.asarray(file["pieces"], np.float64)
    except Exception as error:  # damaged bytes make numpy and zipfile raise anything
        raise ModelError(f"{path} cannot be read: {error}"[:300]) from error
    is_sound = pieces.ndim == 3 and pieces.shape[2] == WIDTH and bool(np.isfinite(pieces).all())
    if not is_sound or pieces.shape[0] <= NEAREST:
        shape = f"finite numbers of shape (over {NEAREST}, n, {WIDTH})"
        raise ModelError(f"{path} holds shape {pieces.shape}, allowed: {shape}")
    return Cohort(unit(pieces)), hashlib.sha256(data).hexdigest()


def write_cohort(pieces: Sequence[Vector], path: Path = PATH) -> None:
    """Keep embeddings, (utterances, WIDTH) of each speaker, with three digits each."""
    np.savez_compressed(path, pieces=np.stack(pieces).astype(np.float16))
