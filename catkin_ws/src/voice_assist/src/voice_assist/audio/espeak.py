# SPDX-License-Identifier: BSD-3-Clause
"""Speech and pronunciation of espeak-ng, a program of the system."""

from __future__ import annotations

import shlex
import subprocess

import numpy as np
from numpy.typing import NDArray

from voice_assist.errors import ModelError

Int16 = NDArray[np.int16]


def run_program(command: list[str], said: str = "") -> bytes:
    """What a program that speaks writes.

    Args:
        command: The program with its arguments.
        said: Given to it as input.

    Raises:
        ModelError: The program is not installed, or fails.
    """
    try:
        done = subprocess.run(command, check=True, capture_output=True, input=said.encode())
        return done.stdout
    except FileNotFoundError as error:
        raise ModelError(f"speech synthesis needs the program {command[0]!r}") from error
    except subprocess.CalledProcessError as error:
        words = " ".join(error.stderr.decode(errors="replace").split()) or str(error)
        raise ModelError(f"{shlex.join(command)}: {words}") from error


def espeak(text: str, voice: str, *options: str) -> tuple[Int16, int]:
    """Sound of espeak-ng as it comes, shape (n,), and its rate [Hz].

    Args:
        text: Words, or phonemes in double square brackets.
        voice: Of espeak-ng, such as "en-gb+f2".
        options: Of its command line, such as "-s", "160" for words per minute.

    Raises:
        ModelError: espeak-ng is not installed, or refuses the voice.
    """
    data = run_program(["espeak-ng", "-v", voice, *options, "--stdout", text])
    rate = int.from_bytes(data[24:28], "little")  # an MBROLA voice has its own
    return np.frombuffer(data[44 : 44 + (len(data) - 44) // 2 * 2], "<i2"), rate


def ipa(text: str, voice: str) -> str:
    """Sounds of a text in the International Phonetic Alphabet.

    Args:
        text: In the voice's language.
        voice: Of espeak-ng, such as "fr-fr".

    Raises:
        ModelError: espeak-ng is not installed, or refuses the voice.
    """
    return " ".join(run_program(["espeak-ng", "-q", "--ipa", "-v", voice, text]).decode().split())
