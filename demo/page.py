# SPDX-License-Identifier: BSD-3-Clause
"""The operator's page of the session: its address, and pictures of it where a browser is."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from queue import Queue

import rospy

from support.browser import MISSING, Browser, find_browser

ADDRESS = "/display/page"  # parameter
SCREENS = {"": (1920, 1080, "light"), "-phone": (390, 844, "dark")}  # pixels, by name of the file
SHOWS_THE_SESSION = "document.getElementById('state').textContent !== 'No news'"
SHOWS_THE_SCENE = (
    "document.getElementById('picture').naturalWidth > 0"
    " && !document.getElementById('picture-words').textContent.startsWith('OLD')"
)
PATIENCE = 3.0  # [s] for the scene, which a busy machine draws late; the moment would be over
LOOK = 0.05  # [s] between two looks for a moment
NOWHERE = "about:blank"  # between pictures: a page that is drawn all the time takes a core


class PagePictures:
    """Says where the page is; photographs it from a thread, in one browser.

    Args:
        folder: For `page-<moment>.png` and `page-<moment>-phone.png`.
        say: Shows a line to the person.
    """

    def __init__(self, folder: Path, say: Callable[[str], None]) -> None:
        self._folder, self._say = folder, say
        self._moments: Queue[str] = Queue()
        self._is_up = threading.Event()  # the browser, or that there will be none
        self._thread = threading.Thread(target=self._run, name="page", daemon=True)

    def start(self) -> None:
        """Begin; only after someone is sure to close it, whatever comes between."""
        if find_browser():
            self._thread.start()
        else:
            self._is_up.set()
            self._say(f"no pictures of the page: {MISSING}")

    def wait_for_browser(self) -> None:
        """Until its start takes no core from those who hear; the page is served by now."""
        self._is_up.wait(PATIENCE)
        self._say(f"operator's page: {_address() or 'none; launch.log says why'}")

    def take(self, moment: str) -> None:
        """Begin the picture of this moment."""
        self._moments.put(moment)

    def close(self) -> None:
        """Wait for the pictures."""
        if self._thread.ident is not None:  # it was started
            self._moments.put("")
            self._thread.join()

    async def _next(self) -> str:
        """The next moment; a thread that waited for it would outlive an interrupted demo."""
        while self._moments.empty():
            await asyncio.sleep(LOOK)
        return self._moments.get()

    def _run(self) -> None:
        try:
            asyncio.run(self._photograph())
        except (RuntimeError, OSError, TimeoutError) as error:
            self._say(f"no pictures of the page: {error}")
        finally:
            self._is_up.set()

    async def _photograph(self) -> None:
        async with Browser() as browser:
            self._is_up.set()
            while (moment := await self._next()) and (address := _address()):
                await browser.open(address)
                await browser.until(SHOWS_THE_SESSION)
                with suppress(RuntimeError):
                    await browser.until(SHOWS_THE_SCENE, PATIENCE)
                for ending, screen in SCREENS.items():
                    await browser.set_screen(*screen)
                    await asyncio.sleep(0.3)  # for the page to be laid out anew
                    await browser.picture(self._folder / f"page-{moment}{ending}.png")
                await browser.open(NOWHERE)
                self._say(f"picture of the page: page-{moment}.png")


def _address() -> str:
    """Of the page; empty: there is none."""
    return str(rospy.get_param(ADDRESS, ""))
