# SPDX-License-Identifier: BSD-3-Clause
"""Whether a file is one of OpenAI's checkpoints, unchanged: python -m ...openai_file FILE."""

from __future__ import annotations

import argparse
import hashlib
from pathlib import Path

import whisper

from voice_assist.errors import ModelError


def openai_name(path: Path) -> str:
    """Name of OpenAI's checkpoint that a file holds, by the digests that the whisper library knows.

    Raises:
        ModelError: It is none of them, or was changed.
    """
    if not path.is_file():
        raise ModelError(f"{path}: no such file")
    found = hashlib.sha256(path.read_bytes()).hexdigest()
    for name, url in whisper._MODELS.items():  # the digest is a part of each address
        if found in url:
            return name
    raise ModelError(f"{path} has the SHA-256 {found[:12]}, allowed: that of a model of OpenAI's")


def main() -> None:
    """Say which one it is; end with an error where it is none."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path)
    path: Path = parser.parse_args().file
    try:
        print(f"{path}: OpenAI's {openai_name(path)}")
    except ModelError as error:
        parser.error(str(error))


if __name__ == "__main__":
    main()
