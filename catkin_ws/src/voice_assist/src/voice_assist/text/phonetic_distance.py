# SPDX-License-Identifier: BSD-3-Clause
"""Texts to sounds of speech, and how alike two sounds are.

Where espeak-ng is installed it pronounces the text, in any of its languages. Without it letters
stand for sounds, by the commonest values of English spelling: coarse, but "pool" is still near
"pull", and nobody has to install anything for a warning.
"""

from __future__ import annotations

import subprocess
import unicodedata
from collections.abc import Sequence
from functools import cache
from shutil import which
from typing import Final

Sounds = tuple[str, ...]

PROGRAM: Final = "espeak-ng"
MISSING: Final = 0.7  # cost of a sound that the other has not; 1 is that of a quite different one
_DIFFERENT = 1.0
_PATIENCE = 10.0  # [s] that the program gets for one text

# Place from the lips back, manner, voiced: International Phonetic Alphabet (2020), coarsened.
_PLACES = ("lip", "tooth", "ridge", "palate", "velum", "throat")
_CONSONANTS: Final = {
    **{"p": "lip stop -", "b": "lip stop +", "m": "lip nasal +", "f": "lip hiss -"},
    **{"v": "lip hiss +", "w": "lip glide +", "θ": "tooth hiss -", "ð": "tooth hiss +"},
    **{"β": "lip hiss +", "t": "ridge stop -", "d": "ridge stop +", "n": "ridge nasal +"},
    **{"s": "ridge hiss -", "z": "ridge hiss +", "l": "ridge side +", "ɾ": "ridge stop +"},
    **{"r": "ridge side +", "ɹ": "ridge glide +", "ʃ": "palate hiss -", "ʒ": "palate hiss +"},
    **{"ɲ": "palate nasal +", "j": "palate glide +", "ʝ": "palate hiss +", "ç": "palate hiss -"},
    **{"k": "velum stop -", "ɡ": "velum stop +", "ŋ": "velum nasal +", "x": "velum hiss -"},
    **{"ɣ": "velum hiss +", "ʁ": "velum hiss +", "h": "throat hiss -", "ʔ": "throat stop -"},
    **{"ɫ": "ridge side +", "ɟ": "palate stop +", "c": "palate stop -", "ʎ": "palate side +"},
}
# Height from closed (0) to open (1), backness from front (0) to back (1).
_VOWELS: Final = {
    **{"i": (0.0, 0.0), "y": (0.0, 0.1), "ɪ": (0.2, 0.2), "ʏ": (0.2, 0.3), "e": (0.35, 0.0)},
    **{"ø": (0.35, 0.2), "ɛ": (0.65, 0.1), "œ": (0.65, 0.3), "æ": (0.85, 0.2), "a": (1.0, 0.4)},
    **{"ɐ": (0.85, 0.5), "ə": (0.5, 0.5), "ɚ": (0.5, 0.5), "ɜ": (0.6, 0.5), "ᵻ": (0.2, 0.4)},
    **{"ʌ": (0.75, 0.7), "ɑ": (1.0, 0.9), "ɒ": (0.95, 1.0), "ɔ": (0.65, 1.0), "o": (0.35, 1.0)},
    **{"ʊ": (0.2, 0.8), "u": (0.0, 1.0), "ɨ": (0.1, 0.5), "ʉ": (0.1, 0.6), "ɯ": (0.0, 0.9)},
}
_LETTERS: Final = (  # longest first; "" is silent
    *(("tch", "tʃ"), ("sch", "ʃ"), ("igh", "aɪ"), ("ough", "o"), ("tion", "ʃən")),
    *(("ch", "tʃ"), ("sh", "ʃ"), ("th", "θ"), ("ph", "f"), ("ng", "ŋ"), ("ck", "k"), ("qu", "kw")),
    *(("wh", "w"), ("kn", "n"), ("wr", "ɹ"), ("ee", "i"), ("ea", "i"), ("ie", "i"), ("oo", "u")),
    *(("ou", "aʊ"), ("ow", "oʊ"), ("ai", "eɪ"), ("ay", "eɪ"), ("ey", "eɪ"), ("oa", "oʊ")),
    *(("aw", "ɔ"), ("au", "ɔ"), ("oi", "ɔɪ"), ("oy", "ɔɪ"), ("ew", "ju"), ("er", "ə"), ("ir", "ɜ")),
    *(("ll", "l"), ("ss", "s"), ("pp", "p"), ("tt", "t"), ("rr", "ɹ"), ("mm", "m"), ("nn", "n")),
    *(("a", "æ"), ("b", "b"), ("c", "k"), ("d", "d"), ("e", "ɛ"), ("f", "f"), ("g", "ɡ")),
    *(("h", "h"), ("i", "ɪ"), ("j", "dʒ"), ("k", "k"), ("l", "l"), ("m", "m"), ("n", "n")),
    *(("o", "ɑ"), ("p", "p"), ("q", "k"), ("r", "ɹ"), ("s", "s"), ("t", "t"), ("u", "ʊ")),
    *(("v", "v"), ("w", "w"), ("x", "ks"), ("y", "i"), ("z", "z")),
)


def can_pronounce() -> bool:
    """Whether espeak-ng is there; without it letters have to do."""
    return which(PROGRAM) is not None


@cache
def languages() -> tuple[str, ...]:
    """Those in which it can be pronounced; none where nothing pronounces."""
    if not can_pronounce():
        return ()
    rows = _answer("--voices").splitlines()[1:]  # below the names of the columns
    return tuple(row.split()[1] for row in rows if len(row.split()) > 1)


def espeak_language(language: str) -> str:
    """What espeak-ng calls a language of the commands."""
    return {"en": "en-us", "fr": "fr-fr"}.get(language, language)


def can_read(text: str) -> bool:
    """Whether the program reads a text aloud; of a kanji it says only that it is one."""
    return not any("\u4e00" <= character <= "\u9fff" for character in text)


@cache
def sounds(text: str, language: str = "en-us") -> Sounds:
    """Sounds of a text, one symbol of the IPA each, without stress and length.

    Args:
        text: Words.
        language: Of espeak-ng, such as "de"; ignored where the program is missing.
    """
    found: Sounds = ()
    if can_pronounce():
        found = _symbols(_answer("-q", "--ipa", "-v", language, "--", text))
    return found or sounds_of_letters(text)


def sounds_of_letters(text: str) -> Sounds:
    """Sounds that letters stand for mostly; a last e after a consonant is silent."""
    said = ""
    for word in text.lower().split():
        is_silent = len(word) > 3 and word.endswith("e") and word[-2] not in "aeiou"
        rest = word[:-1] if is_silent else word
        while rest:
            letters, sound = next(
                ((a, b) for a, b in _LETTERS if rest.startswith(a)), (rest[0], "")
            )
            said, rest = said + sound, rest[len(letters) :]
    return _symbols(said)


def distance(one: Sequence[str], other: Sequence[str]) -> float:
    """How different two rows of sounds are, per sound of the longer; 0: the same, 1: altogether.

    Levenshtein's distance, where a sound in place of a similar one costs little.
    """
    if not one or not other:
        return 0.0 if not one and not other else 1.0
    row = [MISSING * n for n in range(len(other) + 1)]
    for a in one:
        above, row = row, [row[0] + MISSING]
        for n, b in enumerate(other):
            row.append(min(above[n + 1] + MISSING, row[n] + MISSING, above[n] + difference(a, b)))
    return row[-1] / max(len(one), len(other))


@cache
def difference(a: str, b: str) -> float:
    """How different two sounds are, from 0 to 1."""
    if a == b:
        return 0.0
    if a in _VOWELS and b in _VOWELS:
        (height, back), (height_b, back_b) = _VOWELS[a], _VOWELS[b]
        return min(0.15 + abs(height - height_b) * 0.6 + abs(back - back_b) * 0.4, _DIFFERENT)
    if a in _CONSONANTS and b in _CONSONANTS:
        (place, manner, voice), (place_b, manner_b, voice_b) = (
            _CONSONANTS[c].split() for c in (a, b)
        )
        apart = abs(_PLACES.index(place) - _PLACES.index(place_b))
        cost = 0.2 * (voice != voice_b) + 0.4 * (manner != manner_b) + 0.2 * min(apart, 2)
        return min(cost + 0.1, _DIFFERENT)
    return _DIFFERENT


def _answer(*options: str) -> str:
    """What espeak-ng writes; nothing where it fails or takes too long."""
    try:
        done = subprocess.run([PROGRAM, *options], capture_output=True, timeout=_PATIENCE)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return done.stdout.decode("utf-8", "replace") if done.returncode == 0 else ""


def _symbols(ipa: str) -> Sounds:
    """The sounds that the tables know; an r-coloured vowel is one with an r."""
    plain = unicodedata.normalize("NFD", ipa).replace("ɚ", "əɹ").replace("ɝ", "ɜɹ")
    plain = plain.replace("g", "ɡ")
    return tuple(c for c in plain if c in _VOWELS or c in _CONSONANTS)
