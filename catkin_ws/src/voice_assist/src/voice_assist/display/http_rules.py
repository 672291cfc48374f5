# SPDX-License-Identifier: BSD-3-Clause
"""Headers of every answer, and which requests are not answered: those of other web pages."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TypeVar

from aiohttp import web

R = TypeVar("R", bound=web.StreamResponse)

HEADERS: Mapping[str, str] = {
    "Content-Security-Policy": (
        "default-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'; "
        "object-src 'none'; img-src 'self' blob:"
    ),
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), microphone=(), geolocation=()",
    "Server": "display",
}


class HostRules:
    """Which names this server goes by.

    A page of somebody else's can have its own name resolve to this machine (DNS rebinding). Its
    requests then come with that name, and are refused.

    Args:
        address: Where the page is served.
        port: Of that address.
        names: Further names.
    """

    def __init__(self, address: str, port: int, names: Iterable[str]) -> None:
        bare = {address, "localhost", "127.0.0.1", *names}
        shown = {f"[{name}]" if ":" in name else name for name in bare}
        self._hosts = {f"{name}:{port}".lower() for name in shown}
        if port == 80:
            self._hosts |= {name.lower() for name in shown}

    def objection(self, headers: Mapping[str, str]) -> str:
        """Why a request is refused; empty: it is not."""
        if headers.get("Host", "").lower() not in self._hosts:
            return "this name is not one of the page's; display.yaml: hosts"
        origin = headers.get("Origin")
        if origin is not None and origin.lower().removeprefix("http://") not in self._hosts:
            return "another page may not ask here"
        return ""


def answer(status: int, text: str, kind: str = "text/plain") -> web.Response:
    """A short answer in words."""
    return strict(web.Response(status=status, text=text + "\n", content_type=kind))


def strict(response: R) -> R:
    """The same answer with the headers that all have, on a connection that then ends."""
    response.headers.update(HEADERS)
    response.force_close()
    return response
