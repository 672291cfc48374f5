# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of the operator's page: a demo that is interrupted ends, and its browser with it."""

import subprocess
import sys
from pathlib import Path
from unittest import mock

from demo import page
from support.waiting import PATIENCE

INTERRUPTED = """
import threading
from pathlib import Path
from unittest import mock
from demo import page

there = threading.Event()

class Browser:
    async def __aenter__(self):
        there.set()
    async def __aexit__(self, *_):
        pass

with mock.patch.multiple(page, Browser=Browser, find_browser=lambda: "browser", rospy=mock.Mock()):
    page.PagePictures(Path("."), print).start()
    there.wait()
raise KeyboardInterrupt
"""


def test_an_interrupted_demo_ends_though_no_picture_was_asked_for():
    root = Path(__file__).resolve().parents[3]
    words = [sys.executable, "-c", INTERRUPTED]
    done = subprocess.run(words, cwd=root, capture_output=True, text=True, timeout=PATIENCE)
    assert "KeyboardInterrupt" in done.stderr


def test_pictures_that_were_never_begun_can_be_ended():
    with mock.patch.object(page, "rospy"):
        page.PagePictures(Path(), print).close()
