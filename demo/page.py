# SPDX-License-Identifier: BSD-3-Clause
"""The operator's page of the session: its address, and one picture of it where a browser is."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from pathlib import Path

import rospy

from support.browser import MISSING, find_browser, photograph

ADDRESS = "/display/page"  # parameter
SHOWS_THE_SESSION = (
    "document.getElementById('state').textContent !== 'No news'"
    " && document.getElementById('picture').naturalWidth > 0"
    " && !document.getElementById('picture-words').textContent.startsWith('OLD')"
)


class PagePicture:
    """Says where the page is; photographs it in a thread, as starting a browser takes seconds.

    Args:
        file: PNG to write.
        say: Shows a line to the person.
    """

    def __init__(self, file: Path, say: Callable[[str], None]) -> None:
        self._file, self._say = file, say
        self._address = str(rospy.get_param(ADDRESS, ""))
        self._thread: threading.Thread | None = None
        say(f"operator's page: {self._address or 'none; launch.log says why'}")
        if not find_browser():
            say(f"no picture of the page: {MISSING}")

    def take(self) -> None:
        """Begin the picture; only the first call counts."""
        if self._thread is None and self._address and find_browser():
            self._thread = threading.Thread(target=self._photograph, name="page", daemon=True)
            self._thread.start()

    def close(self) -> None:
        """Wait for the picture."""
        if self._thread is not None:
            self._thread.join()

    def _photograph(self) -> None:
        try:
            asyncio.run(photograph(self._address, self._file, SHOWS_THE_SESSION))
            self._say(f"picture of the page: {self._file.name}")
        except (RuntimeError, OSError, TimeoutError) as error:
            self._say(f"no picture of the page: {error}")
