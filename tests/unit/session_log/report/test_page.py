# SPDX-License-Identifier: BSD-3-Clause
"""The page for people who do not see it, or have no pointer, or a small screen."""

import asyncio
import re

import pytest

from session_log.report.page import Image, Section, page
from session_log.report.tables.text_table import TextTable
from support.browser import MISSING, Browser, find_browser

COMMANDS = TextTable(
    ("time", "heard", "command"),
    [("2.0\u00a0s", "“tense”", "tense"), ("60.0\u00a0s", "“stop”", "stop")],
    times=(2.0, 60.0),
    sounds=(b"x", b"x"),
    transcripts=("tense", "stop <now>"),
)
SESSIONS = TextTable(
    tuple(f"column {k}" for k in range(12)),
    [tuple(f"cell {k} of twelve" for k in range(12))],
    is_compact=True,
)
ZOOM = {
    "duration": 100.0,
    "marks": [(2.0, "tense", "#1f2933"), (60.0, "stop", "#1f2933")],
    "speech": [],
    "bands": [{"name": "robot", "spans": [(0.0, 100.0, "active", "#bfe3d6")]}],
    "curves": [
        {"name": "tension [N]", "time": [0.0, 1.0, 2.0, 3.0], "value": [1.0, None, 0.5, 3.0]}
    ],
}
SHOWN = "document.querySelector('canvas').getAttribute('aria-valuetext')"
FOCUS = "document.activeElement"


def text_of():
    image = Image("Timeline", "12 utterances, 2 refused.", b"wide", b"narrow")
    sections = [
        Section("Timeline", image=image, zoom=ZOOM),
        Section("Commands", table=COMMANDS),
        Section("Sessions", table=SESSIONS, search="search words"),
    ]
    return page("Session", "", "", {}, sections)


def test_every_control_and_picture_has_a_name_of_its_own():
    text = text_of()
    assert re.findall(r'class="hear"[^>]*aria-label="([^"]*)"', text) == [
        "hear “tense” at 2.0\u00a0s",
        "hear “stop &lt;now&gt;” at 60.0\u00a0s",
    ]
    assert re.findall(r'alt="([^"]*)"', text) == ["12 utterances, 2 refused."]
    assert text.count("<th ") == text.count('<th scope="col"') == 15
    assert re.search(r'<canvas tabindex="0" role="\w+" aria-label="time axis', text)


async def press(browser, key):
    for kind in ("keyDown", "keyUp"):
        await browser.send("Input.dispatchKeyEvent", type=kind, key=key)


@pytest.fixture
def shown(tmp_path):
    """What a look at a page gives in a browser of this size."""
    if not find_browser():
        pytest.skip(MISSING)

    async def in_browser(look, size):
        async with Browser() as browser:
            await browser.open((tmp_path / "report.html").as_uri(), *size)
            found = await look(browser)
            assert not browser.errors
            return found

    def shown(text, look, *size):
        (tmp_path / "report.html").write_text(text, "utf-8")
        return asyncio.run(in_browser(look, size))

    return shown


async def by_keyboard(browser):
    """Go over the time axis, to a row and back; what was shown after each key."""
    found = [await browser.evaluate(SHOWN)]
    await browser.evaluate("document.querySelector('canvas').focus()")
    for key in ("+", "ArrowRight", "ArrowLeft", "-", "Enter"):
        await press(browser, key)
        found.append(await browser.evaluate(SHOWN))
    found.append(await browser.evaluate(f"{FOCUS}.matches('tr button') && {FOCUS}.innerText"))
    await browser.evaluate(f"{FOCUS}.click()")
    return [*found, await browser.evaluate(SHOWN), await browser.evaluate(f"{FOCUS}.tagName")]


def test_the_time_axis_goes_by_keys_to_a_row_and_back(shown):
    assert shown(text_of(), by_keyboard) == [
        "0.0 to 100.0 seconds",
        "25.0 to 75.0 seconds",
        "30.0 to 80.0 seconds",
        "25.0 to 75.0 seconds",
        "0.0 to 100.0 seconds",
        "0.0 to 100.0 seconds",
        "60.0\u00a0s",
        "55.0 to 65.0 seconds",
        "CANVAS",
    ]


# At which places of the width, from 0 to 1, the picture has something of a curve's colour.
BLUE_AT = """((places) => {
    const canvas = document.querySelector('canvas'), {width, height} = canvas;
    const pixels = canvas.getContext('2d').getImageData(0, 0, width, height).data;
    return places.map((place) => {
        const column = 4 * Math.round(place * (width - 1));
        for (let k = column; k < pixels.length; k += 4 * width) {
            if (pixels[k] < 60 && pixels[k + 2] > 150) return true;
        }
        return false;
    });
})([0.02, 0.2, 0.5, 0.98])"""


async def of_a_curve(browser):
    """Where it is drawn when the middle half of the time is shown."""
    await browser.evaluate("document.querySelector('canvas').focus()")
    await press(browser, "+")
    return await browser.evaluate(BLUE_AT)


def test_a_curve_leads_to_the_samples_beyond_what_is_shown_and_not_left_of_it(shown):
    curve = {"name": "tension [N]", "time": [0.0, 45.0, 55.0, 100.0], "value": [1.0, 2.0, 1.5, 3.0]}
    zoom = {**ZOOM, "bands": [], "marks": [], "curves": [curve]}
    section = Section("Timeline", image=Image("Timeline", "", b"wide", b"narrow"), zoom=zoom)
    text = page("Session", "", "", {}, [section])
    assert shown(text, of_a_curve) == [False, True, True, True]


async def widths(browser):
    """Of the page and of the table of sessions, and how many of its cells are shown."""
    await browser.evaluate("document.querySelectorAll('details').forEach((d) => d.open = true)")
    return await browser.evaluate("""[
        document.documentElement.scrollWidth,
        document.querySelector('.wide').scrollWidth,
        [...document.querySelectorAll('.wide td')].filter((e) => e.offsetWidth > 20).length]""")


def test_on_a_phone_the_table_of_sessions_scrolls_and_hides_no_column(shown):
    page_width, table_width, cells = shown(text_of(), widths, 390, 844)
    assert page_width <= 390 and table_width > 700 and cells == 12
