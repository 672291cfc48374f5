# SPDX-License-Identifier: BSD-3-Clause
"""The few tokens of Whisper's English vocabulary that the small model writes.

Compact ids number them 0..32; the last one stands for all tokens never used.
"""

from __future__ import annotations

from collections.abc import Sequence

from voice_assist.errors import CommandsError
from voice_assist.text.normalize import normalize

N_VOCAB = 51864  # of Whisper's English-only models
CHARACTERS = " 'abcdefghijklmnopqrstuvwxyz"  # each is one token of Whisper's
BLANK = len(CHARACTERS)  # of the CTC head, whose classes are CHARACTERS + blank
END, START, NO_TIMESTAMPS, NO_SPEECH = range(BLANK, BLANK + 4)  # compact ids
GARBAGE = BLANK + 4
N_COMPACT = GARBAGE + 1
PROMPT = (START, NO_TIMESTAMPS)

# Whisper's id of each compact id but GARBAGE.
WHISPER_IDS = (220, 6, *range(64, 90), 50256, 50257, 50362, 50361)
IDS_BY_SIZE = {  # of the vocabulary: English models, and those of many languages up to large-v2
    N_VOCAB: WHISPER_IDS,
    51865: (220, 6, *range(64, 90), 50257, 50258, 50363, 50362),
}

_IDS = {character: index for index, character in enumerate(CHARACTERS)}


def encode(text: str) -> list[int]:
    """Compact ids of normalised text.

    Raises:
        KeyError: A character is not in CHARACTERS.
    """
    return [_IDS[character] for character in text]


def spelled(phrase: str) -> str:
    """A phrase in the letters of the vocabulary: "x-ray 2" is "x ray two", "más" is "mas".

    Raises:
        CommandsError: It has others, such as kana.
    """
    text = " ".join(normalize(phrase))
    if not text or not set(text) <= set(CHARACTERS):
        raise CommandsError("phrase", phrase, "letters a to z for this recogniser")
    return text


def decode(ids: Sequence[int]) -> str:
    """Text of compact ids; ids that are no characters are left out."""
    return "".join(CHARACTERS[index] for index in ids if index < BLANK)
