# SPDX-License-Identifier: BSD-3-Clause
"""Viewers of the operator's page: they take every event and every picture, as the page does."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable

from aiohttp import ClientSession, ClientTimeout

CONNECTING = 1.0  # [s]


async def with_viewers(page: str, viewers: int, act: Callable[[], object]) -> None:
    """Do something in a thread while so many look at a page, all of them connected.

    Args:
        page: Its address.
        viewers: How many.
        act: What is done meanwhile.
    """
    viewing = [asyncio.create_task(_view(page)) for _ in range(viewers)]
    await asyncio.sleep(CONNECTING)
    await asyncio.to_thread(act)
    for viewer in viewing:
        viewer.cancel()
    await asyncio.gather(*viewing, return_exceptions=True)


async def _view(page: str) -> None:
    """As the page does: take every event, and fetch every picture once."""
    shown = 0
    async with (
        ClientSession(timeout=ClientTimeout()) as session,
        session.get(f"{page}/events") as events,
    ):
        async for line in events.content:
            if not line.startswith(b"data:"):
                continue
            picture = json.loads(line.removeprefix(b"data:"))["picture"]
            if picture and picture["number"] != shown:
                shown = picture["number"]
                async with session.get(f"{page}/picture") as answer:
                    await answer.read()
