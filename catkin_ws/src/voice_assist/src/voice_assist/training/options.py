# SPDX-License-Identifier: BSD-3-Clause
"""Types of options that programs of training share, so that a wrong one is refused first."""

from __future__ import annotations

import argparse
from pathlib import Path

import torch

from voice_assist.training.data.human import MANIFEST


def speech_option(words: str) -> Path:
    """Type of an option that is a folder of recordings.

    Raises:
        argparse.ArgumentTypeError: It has no manifest.
    """
    folder = Path(words)
    if not (folder / MANIFEST).is_file():
        raise argparse.ArgumentTypeError(f"{words!r}, allowed: a folder with {MANIFEST}")
    return folder


def device_option(words: str) -> str:
    """Type of an option that is a device of torch's.

    Raises:
        argparse.ArgumentTypeError: torch cannot compute there.
    """
    try:
        torch.zeros(1, device=words).item()
    except (AssertionError, RuntimeError) as error:  # the first: built without CUDA
        allowed = "cpu or cuda" if torch.cuda.is_available() else "cpu; torch finds no other here"
        raise argparse.ArgumentTypeError(f"{words!r}, allowed: {allowed}") from error
    return words
