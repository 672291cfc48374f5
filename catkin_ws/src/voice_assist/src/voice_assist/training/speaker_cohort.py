# SPDX-License-Identifier: BSD-3-Clause
"""Background voices of the speaker gate: python -m voice_assist.training.speaker_cohort SPEECH.

SPEECH is a folder with manifest.csv (columns path, kind, speaker, split, source). Of each speaker
of its training split short utterances are embedded; only the embeddings are kept.
"""

from __future__ import annotations

import argparse
import csv
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from random import Random

import numpy as np

from voice_assist.audio.sound_file import read_sound
from voice_assist.speaker.cohort import PATH, write_cohort
from voice_assist.speaker.network import Vector, VoiceNetwork
from voice_assist.speaker.speech import spoken
from voice_assist.types import RATE, Samples

LENGTHS = (0.5, 0.7, 1.0, 1.6)  # [s] of the utterances kept of each speaker, as commands last
MIN_SPEECH = 5.0  # [s] of speech of a speaker that is used
MAX_SPEECH = 30.0  # [s] that is read of one
KINDS = ("speech", "positive")
Who = tuple[str, str]  # source and speaker


def speech_of(folder: Path, splits: Sequence[str]) -> Iterator[tuple[Who, list[Samples]]]:
    """Speakers with clips without pauses, mixed by chance; those with too little are left out.

    Args:
        folder: With manifest.csv.
        splits: Of the manifest.
    """
    clips: dict[Who, list[str]] = defaultdict(list)
    with (folder / "manifest.csv").open(newline="") as file:
        for row in csv.DictReader(file):
            if row["split"] in splits and row["kind"] in KINDS and row["speaker"]:
                clips[row["source"], row["speaker"]].append(row["path"])
    for who, paths in sorted(clips.items()):
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
    """Write the background voices."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("speech", type=Path)
    parser.add_argument("--out", type=Path, default=PATH)
    options = parser.parse_args()
    embed = VoiceNetwork()
    pieces: list[Vector] = [
        np.stack([embed(u) for u in utterances(clips)])
        for _, clips in speech_of(options.speech, ("train",))
    ]
    write_cohort(pieces, options.out)
    print(f"{len(pieces)} speakers, {options.out.stat().st_size / 1e3:.0f} kB: {options.out}")


if __name__ == "__main__":
    main()
