# SPDX-License-Identifier: BSD-3-Clause
"""`python -m support.documents.sentences [PAGE...]`: sentences of the documents that are too long.

A sentence has 25 words at most. Generated pages, code blocks and headings are left out; each cell
of a table counts by itself. Ends with 1 where a sentence is longer.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[2]
MOST: Final = 25  # words
GENERATED: Final = ("docs/measured.md", "docs/reference/settings.md")
_LEFT_OUT: Final = (
    re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE),
    re.compile(r"<!-- generated: .*?<!-- end of generated -->", re.DOTALL),
    re.compile(r"<!-- figures: .*?<!-- end of figures -->", re.DOTALL),
    re.compile(r"^(#.*|    .*|<!--.*-->|\|[-| ]+\|)$", re.MULTILINE),
)
_LINK: Final = re.compile(r"!?\[([^]]*)\]\([^)]*\)")
_END: Final = re.compile(
    r"(?<=[.!?])[\"')*]*\s+(?=[\"'(*`]*[A-Z0-9\"`])|\n\s*(?:[-*]|\d+\.)\s|\n\n"
)


def pages() -> list[Path]:
    """Pages written by hand."""
    found = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]
    return sorted(p for p in found if str(p.relative_to(ROOT)) not in GENERATED)


def sentences(text: str) -> Iterator[str]:
    """Sentences of a page, and cells of its tables."""
    for pattern in _LEFT_OUT:
        text = pattern.sub("\n\n", text)
    prose = []
    for line in text.splitlines():
        if line.startswith("|"):
            yield from (s for cell in line.strip("|").split("|") for s in _split(cell))
            prose.append("")
        else:
            prose.append(line)
    yield from _split("\n".join(prose))


def too_long(text: str) -> list[tuple[int, str]]:
    """Words and text of each sentence with more than 25."""
    counted = ((len(sentence.split()), sentence) for sentence in sentences(text))
    return [(words, sentence) for words, sentence in counted if words > MOST]


def main(arguments: Sequence[str]) -> int:
    """Print the sentences that are too long; 1 where there are some."""
    parser = argparse.ArgumentParser(prog="support.documents.sentences", description=__doc__)
    parser.add_argument("pages", nargs="*", type=Path, metavar="PAGE", help="all, where none is")
    total = 0
    for page in parser.parse_args(arguments).pages or pages():
        for words, sentence in too_long(page.read_text(encoding="utf-8")):
            total += 1
            print(f"{page.resolve().relative_to(ROOT)}: {words} words: {sentence[:90]}")
    print(f"{total} sentences have more than {MOST} words")
    return int(total > 0)


def _split(text: str) -> Iterator[str]:
    text = re.sub(r"`[^`]*`", "Code", _LINK.sub(r"\1", text))
    for sentence in _END.split(text):
        if words := " ".join(sentence.split()):
            yield words


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
