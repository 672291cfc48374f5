# SPDX-License-Identifier: BSD-3-Clause
"""`python -m support.documents.pages`: writes what the documents take from code and settings files.

Settings come from the comments of the YAML files, commands from `rst_control.commands.table`,
alarms and reason codes from `voice_assist.alarms.catalogue`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from rst_control.commands import table
from voice_assist.alarms import catalogue

ROOT: Final = Path(__file__).resolve().parents[2]
SOURCES: Final = ROOT / "catkin_ws" / "src"
REFERENCE: Final = ROOT / "docs" / "reference"
PACKAGES: Final = ("voice_assist", "rst_control", "session_log")
MARKED: Final = r"(<!-- generated: {} -->\n\n).*?(\n\n<!-- end of generated -->)"

_KEY = re.compile(r"(?P<indent> *)(?P<key>[\w/]+): *(?P<value>[^#]*?)(?: +#(?P<comment>.*))?")
_COMMENT = re.compile(r"(?P<indent> *)# ?(?P<text>.*)")
_ENTRY = re.compile(r" *- ")


@dataclass
class Setting:
    """One key of a settings file."""

    name: str
    value: str
    words: list[str] = field(default_factory=list)

    def row(self) -> str:
        """Its row in the table."""
        value = f"`{self.value}`" if self.value else ""
        cells = (f"`{self.name}`", value, _cell(" ".join(self.words)))
        return f"| {' | '.join(cells)} |"


def read_settings(text: str) -> tuple[str, list[Setting]]:
    """What a settings file says of itself, and its keys with their comments.

    Keys of the entries of a list are left out: the comment before the list explains them.

    Args:
        text: Of the YAML file.
    """
    about: list[str] = []
    settings: list[Setting] = []
    path: list[tuple[int, str]] = []
    entry: int | None = None  # indent of the list that is passed over
    for line in text.splitlines():
        indent = len(line) - len(line.lstrip())
        if entry is not None and (not line.strip() or indent > entry or _ENTRY.match(line)):
            continue
        entry = indent if _ENTRY.match(line) else None
        comment, key = _COMMENT.fullmatch(line), _KEY.fullmatch(line)
        if comment and settings and comment["indent"]:
            settings[-1].words.append(comment["text"].strip())
        elif comment:
            about.append(comment["text"].rstrip())
        elif key and entry is None:
            path = [(depth, name) for depth, name in path if depth < indent]
            path.append((indent, key["key"]))
            name = ".".join(name for _, name in path)
            words = [key["comment"].strip()] if key["comment"] else []
            settings.append(Setting(name, key["value"].strip(), words))
    return "\n".join(about), [s for s in settings if s.value or s.words]


def settings_page(sources: Path = SOURCES) -> str:
    """The page of all settings."""
    parts = [
        "# Settings",
        "Generated from the comments of the YAML files by `python -m support.documents.pages`. "
        "Change them in a copy of the file or of its folder. No key has a default elsewhere; a "
        "missing or unknown key, another type or a value out of its range ends the node at start. "
        "`[unit]` stands before each meaning; `[-]` has none.",
    ]
    for package in PACKAGES:
        parts.append(f"## {package}")
        for file in sorted((sources / package / "config").glob("*.yaml")):
            about, settings = read_settings(file.read_text(encoding="utf-8"))
            parts.append(f"### {file.name}")
            if about:
                parts.append("```text\n" + about + "\n```")
            if settings:
                rows = ["| key | shipped | meaning |", "|---|---|---|"]
                parts.append("\n".join([*rows, *(setting.row() for setting in settings)]))
    return "\n\n".join(parts) + "\n"


def pages() -> Mapping[Path, str]:
    """Each page that holds something generated, as it has to be."""
    found = {REFERENCE / "settings.md": settings_page()}
    for name, block in (("commands", table.markdown()), ("alarms", catalogue.markdown())):
        page = REFERENCE / f"{name}.md"
        found[page] = with_block(page.read_text(encoding="utf-8"), name, block)
    return found


def with_block(text: str, name: str, block: str) -> str:
    """A page with its generated block replaced.

    Args:
        text: Of the page.
        name: Of the block, which its marks bear.
        block: What stands between the marks.

    Raises:
        ValueError: The page does not have the marks once.
    """
    marked = re.compile(MARKED.format(re.escape(name)), re.DOTALL)
    new, count = marked.subn(lambda marks: marks[1] + block + marks[2], text)
    if count != 1:
        raise ValueError(f"{count} blocks are marked '<!-- generated: {name} -->', allowed: 1")
    return new


def main() -> None:
    """Write the pages that changed."""
    for page, text in pages().items():
        if not page.exists() or page.read_text(encoding="utf-8") != text:
            page.write_text(text, encoding="utf-8")
            print(page.relative_to(ROOT))


def _cell(words: str) -> str:
    return re.sub(r" +", " ", words).replace("|", r"\|").replace("<", "&lt;")


if __name__ == "__main__":
    main()
