# SPDX-License-Identifier: BSD-3-Clause
"""The page's words in other languages: each has all of them, and no other."""

from __future__ import annotations

import re

import pytest

from voice_assist.config.display import LANGUAGES
from voice_assist.display.page_texts import ENGLISH, page_texts
from voice_assist.display.server import PAGE

VALUES = {"voice", "unknown", "standby", "active"}  # of the snapshot


def page_keys():
    """Texts of page.js as its function `t` looks them up, those of its tables, and of the HTML."""
    script = (PAGE / "page.js").read_text("utf-8")
    keys = set()
    for begin in re.finditer(r"\bt`", script):
        text, depth, at, values = "", 0, begin.end(), 0
        while script[at] != "`" or depth:
            if script.startswith("${", at):
                text += f"{{{values}}}" if not depth else ""
                values, depth, at = values + (not depth), depth + 1, at + 2
                continue
            depth -= script[at] == "}" and depth > 0
            text += script[at] if not depth and script[at] != "}" else ""
            at += 1
        keys.add(text)
    for table in re.findall(r"const (?:NAMES|PHASES) = \{(.*?)\};", script, re.DOTALL):
        keys.update(re.findall(r': "([^"]+)"', table))
    page = re.sub(r"<!--.*?-->", "", (PAGE / "index.html").read_text("utf-8"), flags=re.DOTALL)
    keys.update(re.findall(r'(?:aria-label|alt)="([^"]+)"', page))
    body = page[page.index("<main>") :]
    return keys | {t.strip() for t in re.findall(r">([^<>]+)<", body) if t.strip()}


@pytest.mark.parametrize("language", LANGUAGES[1:])
def test_every_text_of_the_page_is_there_and_no_other(language):
    found = page_texts(language)
    assert set(found) - VALUES == page_keys() - VALUES
    for english, text in found.items():
        assert sorted(re.findall(r"\{\d\}", text)) == sorted(re.findall(r"\{\d\}", english))


def test_in_english_nothing_is_replaced():
    assert page_texts(ENGLISH) == {}
    assert page_texts("fr")["Ready"] == "Prêt"
