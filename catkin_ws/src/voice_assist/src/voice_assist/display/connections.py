# SPDX-License-Identifier: BSD-3-Clause
"""Connections of browsers: few, short, each for one answer, and never an answer without headers."""

from __future__ import annotations

import asyncio
import logging
import socket
from typing import Any

from aiohttp import web

from voice_assist.display.http_rules import strict

ANSWER_WITHIN = 10.0  # [s] from the first byte to the last, but for a viewer's
SPARE = 50  # connections beside those of viewers
SEND_BUFFER = 65_536  # [B] that the kernel keeps for who does not read
WAITING = 65_536  # [B] of ours above which a writer waits

QUIET_LOG = logging.getLogger("voice_assist.display.http")  # a flood of bad requests is no news
QUIET_LOG.setLevel(logging.CRITICAL + 1)


class Connection(web.RequestHandler):
    """One connection; it ends after one answer or after a time, unless it is a viewer's."""

    _deadline: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begin the time; one connection too many ends at once."""
        super().connection_made(transport)
        assert isinstance(transport, asyncio.Transport)
        manager = self._manager
        if isinstance(manager, Connections) and len(manager.connections) > manager.limit:
            transport.abort()
            return
        transport.set_write_buffer_limits(high=WAITING)
        sock = transport.get_extra_info("socket")
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
        self._deadline = self._loop.call_later(ANSWER_WITHIN, transport.abort)

    def connection_lost(self, exc: BaseException | None) -> None:
        """End the time."""
        self.stay()
        super().connection_lost(exc)

    def stay(self) -> None:
        """It is a viewer's from now on."""
        if self._deadline is not None:
            self._deadline.cancel()

    def handle_error(self, *args: Any, **more: Any) -> web.StreamResponse:
        """The answer to what is no HTTP, or to what failed; it has the headers, too."""
        return strict(super().handle_error(*args, **more))


class Connections(web.Server):
    """Makes connections, up to a limit.

    Args:
        handler: Answers requests.
        viewers: Most viewers.
    """

    def __init__(self, handler: Any, viewers: int) -> None:
        super().__init__(handler)
        self.limit = viewers + SPARE

    def __call__(self) -> web.RequestHandler:
        """A connection."""
        return Connection(self, loop=self._loop, access_log=QUIET_LOG, logger=QUIET_LOG)
