# SPDX-License-Identifier: BSD-3-Clause
"""Background voices of the speaker gate: python -m voice_assist.training.speaker_cohort SPEECH.

SPEECH is a folder with manifest.csv (columns path, kind, speaker, split, source). Of each speaker
of its training split short utterances are embedded; only the embeddings are kept.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from random import Random

import numpy as np

from typed_config import check_writable, replacing, run_command
from voice_assist.audio.sound_file import read_sound
from voice_assist.errors import ManifestError, VoiceError
from voice_assist.speaker.cohort import NEAREST, PATH, write_cohort
from voice_assist.speaker.network import Vector, VoiceNetwork
from voice_assist.speaker.speech import spoken
from voice_assist.text.csv_rows import csv_rows
from voice_assist.training.data.human import MANIFEST, SPEECH_KINDS
from voice_assist.types import RATE, Samples

LENGTHS = (0.5, 0.7, 1.0, 1.6)  # [s] of the utterances kept of each speaker, as commands last
MIN_SPEECH = 5.0  # [s] of speech of a speaker that is used
MAX_SPEECH = 30.0  # [s] that is read of one
SPLITS = ("train",)  # of the background
Who = tuple[str, str]  # source and speaker


def clips_of(folder: Path, splits: Sequence[str]) -> dict[Who, list[str]]:
    """Files of each speaker.

    Args:
        folder: With manifest.csv.
        splits: Of the manifest.

    Raises:
        ManifestError: The manifest is missing, or lacks a column.
    """
    clips: dict[Who, list[str]] = defaultdict(list)
    columns = ("path", "kind", "speaker", "source", "split")
    for _, (path, kind, speaker, source, split) in csv_rows(folder / MANIFEST, *columns):
        if split in splits and kind in SPEECH_KINDS and speaker:
            clips[source, speaker].append(path)
    return clips


def speech_of(folder: Path, splits: Sequence[str]) -> Iterator[tuple[Who, list[Samples]]]:
    """Speakers with clips without pauses, mixed by chance; those with too little are left out.

    Args:
        folder: With manifest.csv.
        splits: Of the manifest.

    Raises:
        AudioError: A clip cannot be read.
        ManifestError: The manifest is missing, or lacks a column.
    """
    for who, paths in sorted(clips_of(folder, splits).items()):
        Random(0).shuffle(paths)
        found: list[Samples] = []
        for path in paths:
            if sum(map(len, found)) < MAX_SPEECH * RATE:
                found.append(spoken(read_sound(folder / path)))
        if sum(map(len, found)) >= MIN_SPEECH * RATE:
            yield who, found


def utterances(clips: Sequence[Samples]) -> list[Samples]:
    """One utterance of each of LENGTHS, from different places."""
    whole, rng = np.concatenate(clips), Random(1)
    starts = [rng.randrange(len(whole) - round(s * RATE)) for s in LENGTHS]
    return [whole[at : at + round(s * RATE)] for at, s in zip(starts, LENGTHS, strict=True)]


def main() -> None:
    """Run the command line; ends with 2 where what was asked cannot be done."""
    if status := run_command(_run, "speaker_cohort", (VoiceError,), failed=2):
        sys.exit(status)


def _run() -> None:
    """Write the background voices."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("speech", type=Path)
    parser.add_argument("--out", type=Path, default=PATH)
    options = parser.parse_args()
    _check_enough(len(clips_of(options.speech, SPLITS)), options.speech)
    check_writable(options.out)
    embed = VoiceNetwork()
    pieces: list[Vector] = [
        np.stack([embed(u) for u in utterances(clips)])
        for _, clips in speech_of(options.speech, SPLITS)
    ]
    _check_enough(len(pieces), options.speech)
    with replacing(options.out, ".npz") as temporary:
        write_cohort(pieces, temporary)
    print(f"{len(pieces)} speakers, {options.out.stat().st_size / 1e3:.0f} kB: {options.out}")


def _check_enough(speakers: int, speech: Path) -> None:
    """Refuse a background that no gate would load."""
    if speakers <= NEAREST:
        enough = f"{MIN_SPEECH:g} s of speech in split {' or '.join(SPLITS)}"
        words = f"{speakers} speakers, needed: more than {NEAREST} with {enough}"
        raise ManifestError(f"{speech / MANIFEST}: {words}")


if __name__ == "__main__":
    main()
