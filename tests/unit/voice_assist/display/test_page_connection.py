# SPDX-License-Identifier: BSD-3-Clause
"""When the page is connected, in a headless browser."""

import asyncio

import pytest

from support.browser import MISSING, find_browser
from support.waiting import PATIENCE
from tests.support.page import enter, text
from tests.unit.voice_assist.display.support.served_page import use_page
from tests.unit.voice_assist.display.support.theatre import (
    HALTED,
    PULLING,
    TISSUE,
    TOKEN,
    make_theatre,
)

pytestmark = pytest.mark.skipif(not find_browser(), reason=MISSING)
HIDDEN = """Object.defineProperty(document, "hidden", { value: %s, configurable: true });
document.dispatchEvent(new Event("visibilitychange"));"""
BLOCKED = """for (const storage of ["localStorage", "sessionStorage"])
  Object.defineProperty(window, storage, { get() { throw new DOMException("blocked"); } });"""
SILENT = 3.0  # [s] as in page.js


async def viewers(server, count):
    """Wait until so many see it."""
    async with asyncio.timeout(PATIENCE):
        while len(server.viewers) != count:
            await asyncio.sleep(0.02)


def test_a_hidden_page_gives_its_connection_back_and_takes_one_when_it_is_shown():
    """A browser has six to one server; with six pages open, a stop had none left."""
    theatre = make_theatre()

    async def use(browser, server):
        theatre.see_robot(PULLING, TISSUE)
        await browser.until(f"{text('state')} === 'Moving'")
        await viewers(server, 1)
        await browser.evaluate(HIDDEN % "true")
        await viewers(server, 0)
        theatre.see_robot(HALTED, TISSUE)
        await asyncio.sleep(SILENT + 0.5)  # it does not connect by itself
        assert len(server.viewers) == 0
        assert await browser.evaluate(text("state")) == "Moving"
        await browser.evaluate(HIDDEN % "false")
        await browser.until(f"{text('state')} === 'Halted'")
        await viewers(server, 1)

    use_page(use, theatre)


def test_a_browser_that_blocks_storage_is_connected_and_keeps_what_was_chosen_while_it_is_open():
    async def use(browser, server):
        await browser.until(f"{text('state')} === 'Moving'")
        choice = "document.getElementById('theme')"
        await browser.evaluate(
            f"{choice}.value = 'dark', {choice}.dispatchEvent(new Event('change'))"
        )
        assert await browser.evaluate("document.documentElement.dataset.theme") == "dark"
        await browser.evaluate(enter(TOKEN))
        assert await browser.evaluate("token") == TOKEN
        assert not browser.errors

    use_page(use, script=BLOCKED)
