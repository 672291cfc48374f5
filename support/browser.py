# SPDX-License-Identifier: BSD-3-Clause
"""A headless Chromium, driven by its DevTools protocol: opens pages and takes pictures of them."""

from __future__ import annotations

import asyncio
import base64
import itertools
import os
import shutil
import signal
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from aiohttp import ClientSession, ClientWebSocketResponse, WSMsgType

from support.waiting import PATIENCE

PROGRAMS = ("chromium-headless-shell", "chromium", "google-chrome", "chrome")
MISSING = "no Chromium: install Debian's chromium-headless-shell (docker/apt-packages-dev.txt)"
# It runs as long as this program holds its end of a pipe, however this program ends: the group of
# processes is killed then. Debian's program is a script; the browser is its child.
WITH_US = '{ "$@" </dev/null; kill -KILL 0; } & read _; kill -KILL 0'


def find_browser() -> str:
    """Path of the program; empty: there is none."""
    return next(filter(None, map(shutil.which, PROGRAMS)), "")


class Browser:
    """One page in a browser of its own, as an asynchronous context.

    Attributes:
        errors: Those that the page wrote to its console.
    """

    def __init__(self) -> None:
        self.errors: list[str] = []
        self._numbers = itertools.count(1)
        self._answers: dict[int, asyncio.Future[dict[str, Any]]] = {}
        self._socket: ClientWebSocketResponse | None = None

    async def __aenter__(self) -> Browser:
        """Start it.

        Raises:
            RuntimeError: There is none, or it does not come up.
        """
        program = find_browser()
        if not program:
            raise RuntimeError(MISSING)
        self._folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        self._process = await asyncio.create_subprocess_exec(
            *("sh", "-c", WITH_US, "browser", program),
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--no-first-run",
            "--hide-scrollbars",
            "--remote-debugging-port=0",
            f"--user-data-dir={self._folder.name}",
            "about:blank",
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.DEVNULL,
            stderr=asyncio.subprocess.DEVNULL,
            start_new_session=True,
        )
        self._session = ClientSession()
        try:
            await self._connect()
        except BaseException:
            await self.__aexit__()
            raise
        return self

    @property
    def group(self) -> int:
        """Number of the group of its processes."""
        return self._process.pid

    async def _connect(self) -> None:
        port = await self._until(self._port, "a port")
        url = await self._until(lambda: self._page(port), "a page")
        self._socket = await self._session.ws_connect(url, max_msg_size=0)
        self._reader = asyncio.create_task(self._read())
        for domain in ("Page", "Runtime", "Log"):
            await self.send(f"{domain}.enable")

    async def __aexit__(self, *_: object) -> None:
        """End it."""
        if self._socket is not None:
            self._reader.cancel()
            await self._socket.close()
        await self._session.close()
        with suppress(ProcessLookupError):
            os.killpg(self.group, signal.SIGKILL)
        await self._process.wait()
        self._folder.cleanup()

    async def open(
        self, url: str, width: int = 1920, height: int = 1080, theme: str = "light"
    ) -> None:
        """Show a page on a screen of that size [pixels], with that preference of colours."""
        await self.set_screen(width, height, theme)
        await self.send("Page.navigate", url=url)
        await self.until("document.readyState === 'complete'")

    async def set_screen(self, width: int, height: int, theme: str) -> None:
        """Change the screen."""
        await self.send(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=width < 900,
        )
        features = [{"name": "prefers-color-scheme", "value": theme}]
        await self.send("Emulation.setEmulatedMedia", features=features)

    async def evaluate(self, script: str) -> Any:
        """Value of an expression in the page.

        Raises:
            RuntimeError: It throws.
        """
        found = await self.send(
            "Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True
        )
        if "exceptionDetails" in found:
            raise RuntimeError(str(found["exceptionDetails"]))
        return found["result"].get("value")

    async def until(self, script: str, limit: float = PATIENCE) -> Any:
        """Wait for an expression to be true.

        Raises:
            RuntimeError: It is not within the limit [s]; names it.
        """
        return await self._until(lambda: self.evaluate(script), script, limit)

    async def picture(self, file: Path, whole: bool = False) -> None:
        """Save what the screen shows, or the whole page, as PNG."""
        shot = await self.send("Page.captureScreenshot", captureBeyondViewport=whole)
        file.write_bytes(base64.b64decode(shot["data"]))

    async def send(self, method: str, **words: Any) -> dict[str, Any]:
        """One request of the protocol.

        Raises:
            RuntimeError: It is refused.
        """
        assert self._socket is not None
        number = next(self._numbers)
        answer = self._answers[number] = asyncio.get_running_loop().create_future()
        await self._socket.send_json({"id": number, "method": method, "params": words})
        reply = await asyncio.wait_for(answer, PATIENCE)
        if "error" in reply:
            raise RuntimeError(f"{method}: {reply['error']}")
        result: dict[str, Any] = reply["result"]
        return result

    async def _read(self) -> None:
        assert self._socket is not None
        async for message in self._socket:
            if message.type is not WSMsgType.TEXT:
                continue
            data = message.json()
            if "id" in data:
                self._answers.pop(data["id"]).set_result(data)
            elif data["method"] == "Runtime.exceptionThrown":
                self.errors.append(str(data["params"]["exceptionDetails"]))
            elif data["method"] == "Log.entryAdded":
                self.errors.append(str(data["params"]["entry"]))

    async def _port(self) -> str:
        if self._process.returncode is not None:
            raise RuntimeError("the browser ended before it was up")
        file = Path(self._folder.name, "DevToolsActivePort")
        port, end, _ = (file.read_text() if file.exists() else "").partition("\n")
        return port if end else ""  # it may be there before it is written

    async def _page(self, port: str) -> str:
        """Address of its page; empty: there is none yet, and it answers already."""
        async with self._session.get(f"http://127.0.0.1:{port}/json/list") as answer:
            pages = await answer.json(content_type=None)
        return next((one["webSocketDebuggerUrl"] for one in pages if one["type"] == "page"), "")

    async def _until(
        self, ask: Callable[[], Any], what: str, limit: float = PATIENCE, every: float = 0.05
    ) -> Any:
        end = asyncio.get_running_loop().time() + limit
        while not (found := await ask()):
            if asyncio.get_running_loop().time() > end:
                raise RuntimeError(f"not within {limit:g} s: {what}")
            await asyncio.sleep(every)
        return found
