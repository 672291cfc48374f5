# SPDX-License-Identifier: BSD-3-Clause
"""Viewers of the operator's page: they take every event and every picture, as the page does."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable

import rospy
from aiohttp import ClientSession, ClientTimeout

from support.waiting import wait_until

CONNECTING = 1.0  # [s]


def with_viewers(viewers: int, act: Callable[[], object]) -> None:
    """Do something in a thread while so many look at the page, all of them connected.

    Args:
        viewers: How many.
        act: What is done meanwhile.

    Raises:
        RuntimeError: There is no page.
    """
    page = str(wait_until(lambda: rospy.get_param("/display/page", ""), "the page"))
    asyncio.run(_act_beside(page, viewers, act))


async def _act_beside(page: str, viewers: int, act: Callable[[], object]) -> None:
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
