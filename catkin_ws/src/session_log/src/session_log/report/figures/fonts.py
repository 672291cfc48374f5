# SPDX-License-Identifier: BSD-3-Clause
"""Fonts of the figures: one for Japanese words beside the usual one, and a word where none is."""

from __future__ import annotations

import logging
import re
import unicodedata
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

from matplotlib import font_manager

USUAL = "DejaVu Sans"  # comes with matplotlib
JAPANESE = {  # fonts by the files that hold them, the preferred one first
    "IPAGothic": "ipag.ttf",
    "IPAexGothic": "ipaexg.ttf",
    "Noto Sans CJK JP": "NotoSansCJK-Regular.ttc",
    "TakaoGothic": "TakaoGothic.ttf",
}
OTHERS_MISSING = "no installed font has these characters of the figures: %s"
JAPANESE_MISSING = OTHERS_MISSING + "; Debian's package fonts-ipafont-gothic has Japanese ones"
MOST_NAMED = 10  # characters
_SCRIPTS = ("HIRAGANA", "KATAKANA", "CJK", "IDEOGRAPHIC", "FULLWIDTH", "HALFWIDTH")
_MISSING = r"Glyph (\d+) .*missing from"

log = logging.getLogger(__name__)
_said: set[str] = set()  # what was said about characters without a font


@cache
def families() -> list[str]:
    """The usual font and the first of the Japanese ones that is installed, if any."""
    known = {font.name for font in font_manager.fontManager.ttflist}
    japanese = next((name for name in JAPANESE if name in known), None) or _found()
    return [USUAL, japanese] if japanese else [USUAL]


@contextmanager
def glyphs_named_once() -> Iterator[None]:
    """Say once which characters have no font, in place of a warning for each of their uses."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.filterwarnings("always", message=_MISSING)
        yield
    missing = set()
    for entry in caught:
        if match := re.match(_MISSING, str(entry.message)):
            missing.add(chr(int(match[1])))
        else:
            warnings.warn_explicit(entry.message, entry.category, entry.filename, entry.lineno)
    if missing:
        is_japanese = any(unicodedata.name(c, "").startswith(_SCRIPTS) for c in missing)
        _say(JAPANESE_MISSING if is_japanese and len(families()) == 1 else OTHERS_MISSING, missing)


def _found() -> str | None:
    """A Japanese font that was installed after matplotlib had listed the fonts."""
    files = {Path(path).name: path for path in font_manager.findSystemFonts()}
    for name, file in JAPANESE.items():
        if file in files:
            font_manager.fontManager.addfont(files[file])
            return name
    return None


def _say(words: str, missing: set[str]) -> None:
    if words not in _said:
        _said.add(words)
        log.warning(words, " ".join(sorted(missing)[:MOST_NAMED]))
