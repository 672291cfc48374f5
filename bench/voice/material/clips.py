# SPDX-License-Identifier: BSD-3-Clause
"""Where human speech lies, and theatre noise to mix below speech."""

from __future__ import annotations

from pathlib import Path

import soundfile

from bench.common.resumable import CACHE
from support.figures import ROOT
from support.theatre_sound import theatre_noise
from voice_assist.types import RATE

SPEECH = ROOT.parent / "shared" / "speech"  # human speech; not part of the product
SEED = 1  # of the training run, so that the held-out voices are those it never heard
NOISES = 8
NOISE_LENGTH = 20.0  # [s]


def theatre() -> Path:
    """Folder with theatre noise of several seeds."""
    folder = CACHE / "theatre"
    folder.mkdir(parents=True, exist_ok=True)
    for seed in range(NOISES):
        path = folder / f"{seed}.wav"
        if not path.is_file():
            soundfile.write(path, theatre_noise(NOISE_LENGTH, 0.1, 100 + seed), RATE)
    return folder
