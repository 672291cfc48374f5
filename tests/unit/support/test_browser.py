# SPDX-License-Identifier: BSD-3-Clause
"""The browser ends with the program that started it, however that ends."""

import os
import signal
import subprocess
import sys

import pytest

from support.browser import MISSING, find_browser
from support.waiting import wait_until

PROGRAM = """
import asyncio
from support.browser import Browser

async def show():
    async with Browser() as browser:
        await browser.open("data:text/html,<title>there</title>")
        print(browser.group, flush=True)
        await asyncio.Event().wait()

asyncio.run(show())
"""


def is_gone(group):
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return True
    return False


@pytest.mark.skipif(not find_browser(), reason=MISSING)
def test_a_killed_program_leaves_no_browser():
    program = subprocess.Popen([sys.executable, "-c", PROGRAM], stdout=subprocess.PIPE, text=True)
    group = int(program.stdout.readline())
    assert not is_gone(group)
    program.send_signal(signal.SIGKILL)
    program.communicate()
    wait_until(lambda: is_gone(group))
