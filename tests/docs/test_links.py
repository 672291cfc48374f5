# SPDX-License-Identifier: BSD-3-Clause
"""Every link within the documents leads to a file, and to a heading of it."""

from __future__ import annotations

import re
import subprocess
from functools import cache
from pathlib import Path

from tests.support.checkout import needs_git

ROOT = Path(__file__).resolve().parents[2]
LINK = re.compile(r"\]\((?!\w+:)(?P<path>[^)#\s]*)(?:#(?P<anchor>[^)\s]+))?\)")
FENCE = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)
PAGE_NAMED = re.compile(r"\bdocs/[\w/-]+\.md\b")


def tracked(*patterns: str) -> list[str]:
    """Files of the repository that fit one of git's patterns and are there."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", *patterns],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    return [name for name in listed.stdout.splitlines() if (ROOT / name).is_file()]


def anchors(text: str) -> set[str]:
    """Anchors that GitHub makes of the headings of a page."""
    found: dict[str, int] = {}
    for heading in re.findall(r"^#+ +(.*)$", FENCE.sub("", text), re.MULTILINE):
        words = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading).lower()
        slug = re.sub(r"[^\w\- ]", "", words).strip().replace(" ", "-")
        found[slug] = found.get(slug, -1) + 1
    return {slug + (f"-{n}" if n else "") for slug, last in found.items() for n in range(last + 1)}


@cache
def anchors_of(page: Path) -> set[str]:
    return anchors(page.read_text(encoding="utf-8"))


def broken(name: str, text: str) -> list[str]:
    """Links of a page that lead nowhere."""
    page, found = ROOT / name, []
    for link in LINK.finditer(FENCE.sub("", text)):
        target = (page.parent / link["path"]).resolve() if link["path"] else page
        is_there = target.exists()
        if is_there and link["anchor"]:
            known = anchors(text) if target == page else anchors_of(target)
            is_there = link["anchor"] in known
        if not is_there:
            found.append(f"{name}: {link[0]}")
    return found


@needs_git
def test_every_link_leads_somewhere():
    pages = tracked("*.md")
    assert len(pages) > 20
    assert not [link for name in pages for link in broken(name, (ROOT / name).read_text("utf-8"))]


@needs_git
def test_every_page_that_a_file_names_is_there():
    named = subprocess.run(
        ["git", "grep", "-hoE", r"\bdocs/[a-zA-Z0-9_/-]+\.md\b"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    pages = {name for name in named.stdout.split() if PAGE_NAMED.fullmatch(name)}
    assert len(pages) > 10
    assert not [name for name in sorted(pages) if not (ROOT / name).is_file()]


def test_a_link_that_leads_nowhere_is_found():
    text = "# One two\n[a](#one-two) [b](#three) [c](README.md) [d](nothing.md) [e](https://x.org)"
    assert broken("README.md", text) == ["README.md: ](#three)", "README.md: ](nothing.md)"]
    assert anchors("# A `b`, c\n# A `b`, c\n") == {"a-b-c", "a-b-c-1"}


@needs_git
def test_every_page_is_in_the_index():
    index = ROOT / "docs" / "index.md"
    listed = {(index.parent / m["path"]).resolve() for m in LINK.finditer(index.read_text("utf-8"))}
    pages = {(ROOT / name) for name in tracked("docs/**.md", "*.md") if name.startswith("docs/")}
    assert not sorted(str(page) for page in pages - listed - {index})
