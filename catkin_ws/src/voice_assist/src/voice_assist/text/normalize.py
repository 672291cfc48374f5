# SPDX-License-Identifier: BSD-3-Clause
"""Text as it was heard to words that can be compared."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable

Words = tuple[str, ...]

NEGATIONS = frozenset(
    (
        *("not", "no", "never", "dont", "nor", "neither", "without", "cannot"),
        *("nicht", "nie", "kein", "keine", "ohne"),  # German
        *("nunca", "tampoco", "sin"),  # Spanish
        *("ne", "pas", "jamais", "sans"),  # French
        *("ない", "なく", "ません", "だめ"),  # Japanese
        *(f"{verb_end}な" for verb_end in "うくぐすつぬぶむる"),  # "do not", behind a verb
    )
)

LONGEST = 2000  # characters that are read: a minute of fast talk; an utterance lasts 8 s at most

_APOSTROPHES = str.maketrans(dict.fromkeys("\u2019\u2018\u02bc\u00b4`\u02b9\uff07", "'"))
_IRREGULAR = {
    **{"won't": "will not", "can't": "can not", "shan't": "shall not", "ain't": "is not"},
    **{"let's": "let us", "it's": "it is", "that's": "that is", "what's": "what is"},
    **{"he's": "he is", "she's": "she is", "there's": "there is"},
    **{"gonna": "going to", "wanna": "want to", "dont": "do not", "cant": "can not"},
    **{"wont": "will not", "doesnt": "does not", "didnt": "did not", "isnt": "is not"},
    **{"shouldnt": "should not", "cannot": "can not"},
}
_ENDINGS = (
    *(("n't", " not"), ("'re", " are"), ("'ll", " will"), ("'ve", " have")),
    *(("'m", " am"), ("'d", " would")),
)
_ONES = (
    *("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten"),
    *("eleven", "twelve", "thirteen", "fourteen", "fifteen", "sixteen", "seventeen", "eighteen"),
    "nineteen",
)
_TENS = ("twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety")
_POINT = re.compile(r"(?<![^\W\d])\.(\d+)")  # of a number such as 1.5 or .5
_VOICED = "\u3099\u309a"  # marks of kana that NFKD parts from them
_KATAKANA = {code: code - 0x60 for code in range(0x30A1, 0x30F7)}  # to hiragana
_JAPANESE = r"[\u3005\u3041-\u30ff\u4e00-\u9fff]"  # kana and kanji, which no space parts
_DENIES = "|".join(sorted(word for word in NEGATIONS if re.match(_JAPANESE, word)))
_LETTER = rf"(?:(?!{_JAPANESE})[^\W\d_])"
_TOKEN = re.compile(rf"{_DENIES}|{_JAPANESE}|{_LETTER}+(?:'{_LETTER}+)*|\d+")


def normalize(text: str) -> Words:
    """Words of a text in lower case, without punctuation, contractions, accents or digits.

    The point in a number is a word, and so is each digit behind it: "1.25" is "one point two five".
    In Japanese each character is a word, kana in hiragana; what denies is one word, too.

    Args:
        text: Any text, such as a transcript with punctuation. Its first LONGEST characters are
            read, since the time to take accents off may grow with the square of their number.

    Returns:
        Words of letters only; empty for text without a word.
    """
    read = text[:LONGEST].translate(_APOSTROPHES)
    folded = unicodedata.normalize("NFKD", read).casefold()
    folded = _POINT.sub(lambda number: f" point {' '.join(number[1])}", folded)
    bare = "".join(c for c in folded if c in _VOICED or not unicodedata.combining(c))
    kana = unicodedata.normalize("NFC", bare).translate(_KATAKANA)
    plain = "".join(c if c.isalpha() or c.isdecimal() or c == "'" else " " for c in kana)
    return tuple(word for token in _TOKEN.findall(plain) for word in _expand(token))


def as_text(words: Words) -> str:
    """Words as they are written; no space parts kana and kanji."""
    return re.sub(f"(?<={_JAPANESE}) (?={_JAPANESE})", "", " ".join(words))


def with_same_words(text: str, others: Iterable[str]) -> str:
    """The first of other texts that has the words of this one; empty: none has."""
    words = normalize(text)
    return next((other for other in others if normalize(other) == words), "")


def is_japanese(text: str) -> bool:
    """Whether a kana or a kanji stands in it."""
    return re.search(_JAPANESE, text) is not None


def is_too_long(text: str) -> bool:
    """Whether a text is longer than what `normalize` reads of it."""
    return len(text) > LONGEST


def foreign(text: str, known: frozenset[str] = frozenset()) -> str:
    """The first character that no sentence of the language has; empty: there is none.

    Such are letters of other scripts, of which some look like ours, letters with accents, marks
    that combine with the one before, and those that cannot be seen. Dashes, quotation marks and
    spaces are none.

    Args:
        text: Any text.
        known: Characters that the language has and English has not, in lower case.
    """
    odd = (c for c in text if not c.isascii() and c.lower() not in known)
    return next((c for c in odd if unicodedata.category(c)[0] not in "PZ"), "")


def contains(words: Words, some: Words) -> bool:
    """Whether some words stand among the words, in their order and next to each other."""
    length = len(some)
    return any(words[i : i + length] == some for i in range(len(words) - length + 1))


def is_negated(words: Words) -> bool:
    """Whether a word among them denies."""
    return not NEGATIONS.isdisjoint(words)


def spoken_number(value: int) -> str:
    """A whole number from 0 to 999,999 in English words; larger ones digit by digit."""
    if value < 20:
        return _ONES[value]
    if value < 100:
        tens, ones = divmod(value, 10)
        return _TENS[tens - 2] + (f" {_ONES[ones]}" if ones else "")
    if value < 1000:
        hundreds, rest = divmod(value, 100)
        return f"{_ONES[hundreds]} hundred" + (f" {spoken_number(rest)}" if rest else "")
    if value < 1_000_000:
        thousands, rest = divmod(value, 1000)
        return f"{spoken_number(thousands)} thousand" + (f" {spoken_number(rest)}" if rest else "")
    return " ".join(_ONES[int(digit)] for digit in str(value))


def _expand(token: str) -> list[str]:
    if token.isdigit():
        digits = token[:18]  # no number in speech is longer
        return spoken_number(int(digits)).split()
    if token in _IRREGULAR:
        return _IRREGULAR[token].split()
    for ending, words in _ENDINGS:
        if token.endswith(ending) and len(token) > len(ending):
            return (token[: -len(ending)] + words).split()
    return [token.replace("'", "")]
