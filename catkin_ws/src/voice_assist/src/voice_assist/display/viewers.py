# SPDX-License-Identifier: BSD-3-Clause
"""Hands every event to all viewers; one that does not read is dropped, and delays nobody."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator


class Viewer:
    """One open page: events in order, until it is dropped."""

    def __init__(self, backlog: int) -> None:
        self._queue: asyncio.Queue[bytes] = asyncio.Queue(backlog)
        self._dropped = asyncio.Event()

    @property
    def is_dropped(self) -> bool:
        """Whether it has been given up."""
        return self._dropped.is_set()

    def offer(self, data: bytes) -> None:
        """Queue an event; with a full queue the viewer is dropped."""
        try:
            self._queue.put_nowait(data)
        except asyncio.QueueFull:
            self.drop()

    def drop(self) -> None:
        """Give it up."""
        self._dropped.set()

    async def dropped(self) -> None:
        """Wait until it has been given up."""
        await self._dropped.wait()

    async def __aiter__(self) -> AsyncIterator[bytes]:
        """Events as they come."""
        while not self.is_dropped:
            yield await self._queue.get()


class Viewers:
    """All open pages.

    Args:
        limit: Most of them.
        backlog: Events that may wait for each.
    """

    def __init__(self, limit: int, backlog: int) -> None:
        self._limit, self._backlog = limit, backlog
        self._all: set[Viewer] = set()

    def __len__(self) -> int:
        return len(self._all)

    def join(self) -> Viewer | None:
        """A new viewer; None: there are too many."""
        if len(self._all) >= self._limit:
            return None
        viewer = Viewer(self._backlog)
        self._all.add(viewer)
        return viewer

    def leave(self, viewer: Viewer) -> None:
        """Forget a viewer."""
        self._all.discard(viewer)

    def drop_all(self) -> None:
        """Give all up, as when the server ends."""
        for viewer in self._all:
            viewer.drop()

    def publish(self, data: bytes) -> None:
        """Offer an event to all."""
        for viewer in tuple(self._all):
            viewer.offer(data)
            if viewer.is_dropped:
                self._all.discard(viewer)
