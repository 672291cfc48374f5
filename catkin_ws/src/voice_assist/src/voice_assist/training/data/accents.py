# SPDX-License-Identifier: BSD-3-Clause
"""English in the sounds of other languages, as IPA for Kokoro's voices.

The rules say what speakers of a language most often do to English sounds. Their source is M. Swan
and B. Smith (ed.), Learner English, 2nd edition, Cambridge University Press 2001: the chapter of
each language, section Phonology. No rule takes away the sounds that distinguish two commands, and
none puts a vowel behind "tense", for that makes "tenso" of it, which is another word.
"""

from __future__ import annotations

import re
from functools import cache

from voice_assist.audio.espeak import ipa

_Rules = tuple[tuple[str, str], ...]
_VOWEL = "aeiouæɐɑɒɔəɚɛɜɪʊʌœɯɨᵻ"
_PURE: _Rules = (  # five or so vowels, none of them lax, long or gliding
    *(("ɜːɹ?", "ɛɾ"), ("ɚ", "ɛɾ"), ("oʊ|əʊ", "o"), ("ɔː|ɒ|ɑː", "o"), ("oː", "o")),
    *(("[ɪᵻ]|iː", "i"), ("ʊ|uː", "u"), ("[ʌɐæ]", "a"), ("ə", "e"), ("ː", "")),
)
_R_TAPPED: _Rules = (("ɹ", "ɾ"),)
_TH_STOPPED: _Rules = (("θ", "t"), ("ð", "d"))
_TH_HISSED: _Rules = (("θ", "s"), ("ð", "z"))
_VOWEL_BEFORE_S: _Rules = ((r"\bs(?=ˈ?[ptk])", "es"),)

ACCENTS: dict[str, _Rules] = {
    "Spanish": (*_VOWEL_BEFORE_S, *_PURE, *_R_TAPPED, ("z", "s"), ("v", "b"), ("h", "x")),
    "Portuguese": (
        *(*_VOWEL_BEFORE_S, *_PURE),
        *((rf"l(?= |$|[^ˈˌ{_VOWEL}])", "w"), (r"\bɹ", "h"), ("ɹ", "ɾ"), (r"([ptk])\b", r"\1i")),
    ),
    "Italian": (*_PURE, *_R_TAPPED, *_TH_STOPPED, ("h", ""), (r"([ptkbdɡ])\b", r"\1ə")),
    "French": (
        *(("h", ""), ("ɜːɹ?|ɚ", "œʁ"), ("ɹ", "ʁ"), ("oʊ|əʊ|oː", "o"), ("ɑː", "ɔ"), ("[ɪᵻ]", "i")),
        *(*_TH_HISSED, ("ʊ", "u"), ("ʌ", "œ"), ("tʃ", "ʃ"), ("dʒ", "ʒ"), ("ː", "")),
    ),
    "German": (
        *((r"b\b", "p"), (r"d\b", "t"), (r"ɡ\b", "k"), (r"z\b", "s"), (r"v\b", "f"), ("w", "v")),
        *(*_TH_HISSED, ("ɜːɹ?", "œɐ"), ("oːɹ", "oːɐ"), ("ɹ", "ʁ"), ("æ", "ɛ"), ("oʊ|əʊ", "oː")),
    ),
    "Hindi": (
        *(("t(?!ʃ)", "ʈ"), ("d(?!ʒ)", "ɖ"), ("[wv]", "ʋ"), *_R_TAPPED, ("θ", "t"), ("ð", "d")),
        *(("oʊ|əʊ", "o"), ("eɪ", "e"), ("ɜː", "əɾ")),
    ),
    "Chinese": (
        *(("v", "w"), ("θ", "s"), ("ð", "z"), ("[ɪᵻ]", "i"), ("æ", "ɛ"), ("ː", "")),
        *(("l(?= m)", "o"), (r"([ptk])\b", r"\1ə")),
    ),
    "Japanese": (
        *(("ɜːɹ?|ɚ", "a"), (r"oːɹ|ɔː\b", "oa"), ("oʊ|əʊ", "o"), ("ɑː|ɒ|ɔː", "o"), ("l|ɹ", "ɾ")),
        *(("[ɪᵻ]", "i"), ("ʊ|uː", "ɯ"), ("[ʌɐæə]", "a"), ("θ", "s"), ("ð", "z"), ("v", "b")),
        *(("ː", ""), (rf"([td])(?![ˈˌʃʒ]*[{_VOWEL}])", r"\1o")),
        (rf"([pkbɡmsfzɾ])(?![ˈˌ]*[{_VOWEL}])", r"\1ɯ"),
    ),
}
_SWITCH = re.compile(r"\([a-z-]+\)")  # espeak-ng names the language that it changes to
# Symbols of espeak-ng that Kokoro's network has another one for.
_KOKORO = (
    *(("eɪ", "A"), ("oʊ", "O"), ("əʊ", "Q"), ("aɪ", "I"), ("aʊ", "W"), ("ɔɪ", "Y")),
    *(("tʃ", "ʧ"), ("dʒ", "ʤ"), ("ɚ", "əɹ"), ("ɐ", "ə"), ("ː", "")),
)


@cache
def english(text: str, *, british: bool, accent: str = "") -> str:
    """Sounds of an English text for Kokoro's network.

    Args:
        text: English.
        british: In a British voice's vowels, else an American one's.
        accent: A key of ACCENTS, or nothing for a native's.

    Raises:
        ModelError: espeak-ng is not installed.
    """
    sounds = ipa(text, "en-gb" if british else "en-us")
    for pattern, replacement in ACCENTS[accent] if accent else ():
        sounds = re.sub(pattern, replacement, sounds)
    return for_kokoro(sounds)


def for_kokoro(sounds: str) -> str:
    """IPA of espeak-ng in the symbols of Kokoro's network, with a full stop."""
    sounds = _SWITCH.sub("", sounds)
    for symbol, own in _KOKORO:
        sounds = sounds.replace(symbol, own)
    return f"{sounds}."
