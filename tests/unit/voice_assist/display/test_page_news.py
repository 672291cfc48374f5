# SPDX-License-Identifier: BSD-3-Clause
"""What is old, late or not measured is not shown as if it were now, in a headless browser."""

import asyncio
import time
from dataclasses import replace

import numpy as np
import pytest

from rst_control.simulation.rendering.painter import png_bytes
from support.browser import MISSING, find_browser
from support.waiting import PATIENCE
from tests.support.page import text
from tests.unit.voice_assist.display.support.served_page import use_page
from tests.unit.voice_assist.display.support.theatre import (
    PULLING,
    STOPPED,
    TISSUE,
    make_theatre,
)
from voice_assist.display.snapshot import AlarmPart
from voice_assist.display.theatre import Theatre

pytestmark = pytest.mark.skipif(not find_browser(), reason=MISSING)
PICTURE = png_bytes(np.zeros((80, 120, 3), np.uint8))
IS_LOST = "!document.getElementById('lost').hidden"
IS_OLD = "document.getElementById('picture-frame').classList.contains('is-old')"
IS_SHOWN = "!document.getElementById('picture').hidden"
MOVING = f"{text('state')} === 'Moving'"


def late(seconds):
    """Fresh news come, and the same again that late; what the page says then."""
    return f"""(() => {{
        for (const part of [news.robot, news.hearing, news.tissue]) part.age = 0;
        source.onopen();
        source.onmessage({{ data: JSON.stringify(news) }});
        news.steady -= {seconds};
        source.onmessage({{ data: JSON.stringify(news) }});
        return [{IS_LOST}, document.title, {text("announce")}];
    }})()"""


class RunningClock:
    """A steady clock that a test puts forward."""

    def __init__(self):
        self.ahead = 0.0  # [s]

    def __call__(self):
        return time.monotonic() + self.ahead


def test_a_snapshot_that_is_late_is_as_old_as_it_is_late():
    async def use(browser, server):
        await browser.until(f"{MOVING} && !({IS_LOST})")
        is_lost, title, said = await browser.evaluate(late(20.0))
        assert is_lost and title == "No connection"
        parts = ("connection", "news of the controller", "news of the voice")
        assert all(f"No {part}" in said for part in parts)  # in one text: the last one is read
        await browser.until(f"!({IS_LOST}) && {text('announce')}.includes('Connected')")

    use_page(use)


def test_a_server_with_another_clock_is_not_late():
    async def use(browser, server):
        await browser.until(MOVING)
        steady = "news.steady -= 1e6, source.onmessage({ data: JSON.stringify(news) })"
        assert not await browser.evaluate(f"source.onopen(), {steady}, {IS_LOST}")

    use_page(use)


def test_of_a_controller_that_is_silent_the_title_says_no_state():
    theatre = make_theatre()

    async def use(browser, server):
        async with asyncio.timeout(PATIENCE):
            while not await browser.evaluate("document.title.startsWith('Moving')"):
                theatre.see_robot(PULLING, TISSUE)
        await browser.until("document.title.startsWith('No news')")

    use_page(use, theatre)


def test_a_tension_that_nobody_measures_or_relies_on_is_no_number():
    theatre = make_theatre()
    theatre.see_robot(PULLING, replace(TISSUE, tension=0.0))
    bar = "document.getElementById('tension-bar').getAttribute('aria-valuetext')"

    async def use(browser, server):
        await browser.until(f"{text('tension')} === '0.00 N'")
        assert await browser.evaluate(bar) == "0.00 newton"
        theatre.see_tension_distrust("tension.source is none")
        await browser.until(f"{text('tension')} === 'no value'")
        assert await browser.evaluate(bar) == "no value"
        assert "tension.source is none" in await browser.evaluate(text("tension-target"))

    use_page(use, theatre)


def test_a_picture_that_is_old_says_so_on_itself_and_goes_with_the_camera():
    """The camera goes as the page's server is started anew."""
    clock = RunningClock()
    theatre = make_theatre(clock)
    theatre.see_picture_period(300.0)

    async def use(browser, server):
        theatre.see_picture("image/png", PICTURE, 10.0)
        await browser.until(IS_SHOWN)
        assert not await browser.evaluate(IS_OLD)
        clock.ahead += 1000.0
        theatre.see_picture("image/png", PICTURE, 10.0)  # the same once more
        await browser.until(IS_OLD)
        theatre.see_picture("image/png", PICTURE, 11.0)
        await browser.until(f"{IS_SHOWN} && !{IS_OLD}")
        server._theatre = Theatre(0.5, clock, clock)
        await browser.until(f"!({IS_SHOWN}) && !{IS_OLD}")
        assert await browser.evaluate(text("picture-words")) == "No picture of the scene"

    use_page(use, theatre)


@pytest.mark.parametrize(
    ("alarm", "shape", "words"),
    [
        (STOPPED, "square", "Stop !! medium"),
        (AlarmPart("fault", 3, "arm is behind"), "warning", "Fault !!! high"),
        (AlarmPart("refusal", 1, "wake me first"), "cross", "Refusal ! low"),
        (AlarmPart("refusal", 0, "pull more?"), "cross", "Refusal"),
    ],
)
def test_an_alarm_has_the_symbol_and_words_of_its_kind_and_priority(alarm, shape, words):
    theatre = make_theatre()

    async def use(browser, server):
        theatre.see_alarm(alarm)
        await browser.until(f"{text('alarm-cause')} === {alarm.cause!r}")
        used = "document.getElementById('alarm-shape').getAttribute('href')"
        assert await browser.evaluate(used) == f"#{shape}"
        assert await browser.evaluate(text("alarm-kind")) == words
        assert await browser.evaluate(text("alarm-acknowledged")) == ""
        assert (await browser.evaluate(text("alert"))).startswith(f"{words}: {alarm.cause}")
        theatre.see_alarm(replace(alarm, is_acknowledged=True))
        await browser.until(f"{text('alarm-acknowledged')} === 'acknowledged'")

    use_page(use, theatre)
