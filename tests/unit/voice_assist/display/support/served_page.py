# SPDX-License-Identifier: BSD-3-Clause
"""Lets a test use a page over real sockets, and reads what the page answers."""

import asyncio
import json

from aiohttp import ClientSession, ClientTimeout, TCPConnector

from support.browser import Browser
from support.waiting import PATIENCE
from tests.unit.voice_assist.display.support.theatre import TOKEN, make_server
from voice_assist.display.http_rules import HEADERS

LIMIT = ClientTimeout(PATIENCE)
RIGHT = {"Authorization": f"Bearer {TOKEN}"}


def run(act, **settings):
    """Let `act(server, session)` use a page; gives what it returns."""

    async def inner():
        connector = TCPConnector(limit=0)
        async with (
            make_server(**settings) as server,
            ClientSession(server.address, timeout=LIMIT, connector=connector) as session,
        ):
            return await act(server, session)

    return asyncio.run(inner())


def use_page(use, theatre=None, script="", **settings):
    """Let `use(browser, server)` use a page that is open; a script runs before its own ones."""

    async def inner():
        async with make_server(theatre, **settings) as server, Browser() as browser:
            await browser.send("Page.addScriptToEvaluateOnNewDocument", source=script)
            await browser.open(server.address)
            await use(browser, server)

    asyncio.run(inner())


def assert_strict(headers):
    for name, value in HEADERS.items():
        assert headers.get(name) == value, name
    assert headers.get("Connection", "close") == "close"  # HTTP/1.0 ends by itself


async def first_event(response):
    line = await response.content.readline()
    return json.loads(line.removeprefix(b"data: "))


async def next_event(response):
    """Its line; an empty one follows."""
    line = await response.content.readline()
    await response.content.readline()
    return line
