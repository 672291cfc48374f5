# SPDX-License-Identifier: BSD-3-Clause
"""Commands of ROS in the fenced blocks of the documentation, and why some are not executed."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
PAGES = (
    "README.md",
    *sorted(str(page.relative_to(ROOT)) for page in (ROOT / "docs").rglob("*.md")),
)
MARKERS = ROOT / "tests" / "rostest" / "documents" / "doc_examples.yaml"
PROGRAMS = ("rosservice", "rostopic", "rosrun", "roslaunch")
FENCE = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)
COMMAND = re.compile(
    rf"^(?:docker run .* voice_assist )?((?:\w+=\S+ )*(?:{'|'.join(PROGRAMS)}) .*)"
)


@dataclass(frozen=True)
class DocLine:
    """One command as a page has it, its comment left off."""

    page: str
    number: int
    text: str

    @property
    def words(self) -> list[str]:
        """The command as the shell would split it."""
        return shlex.split(self.text, comments=True)

    @property
    def program(self) -> str:
        """The one that runs, behind what is set for it alone."""
        return next(word for word in self.words if word in PROGRAMS)


@dataclass(frozen=True)
class Marker:
    """What is said of the lines that begin so."""

    begins: str
    system: str  # what has to run for it, as doc_examples.yaml calls it; "": it is not executed
    reason: str  # why it is not executed; "": it is

    def covers(self, line: DocLine) -> bool:
        """Whether this is said of the line."""
        return line.text.startswith(self.begins)


def doc_lines(text: str, page: str) -> list[DocLine]:
    """Commands of ROS in the fenced blocks of a page."""
    found = []
    for block in FENCE.finditer(text):
        first = text.count("\n", 0, block.start()) + 1
        joined = block.group().replace("\\\n", " ")
        for offset, line in enumerate(joined.splitlines()):
            if command := COMMAND.match(line):
                found.append(DocLine(page, first + offset, _plain(command[1])))
    return found


def all_lines() -> list[DocLine]:
    """Those of all pages, in order."""
    return [line for page in PAGES for line in doc_lines((ROOT / page).read_text("utf-8"), page)]


@cache
def markers() -> list[Marker]:
    """What doc_examples.yaml says."""
    data = yaml.safe_load(MARKERS.read_text(encoding="utf-8"))
    executed = [Marker(begins, name, "") for name, rows in data["run"].items() for begins in rows]
    return [
        *(Marker(row["line"], "", row["reason"]) for row in data["not_run"]),
        *executed,
    ]


def marker_of(line: DocLine) -> Marker | None:
    """What is said of a line, by the marker with the longest beginning; None: nothing."""
    covering = [marker for marker in markers() if marker.covers(line)]
    return max(covering, key=lambda marker: len(marker.begins), default=None)


def _plain(line: str) -> str:
    """The line without a comment at its end."""
    return re.sub(r"\s+#.*$", "", line).strip()
