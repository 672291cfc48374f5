# SPDX-License-Identifier: BSD-3-Clause
"""What a person does on the page, in a headless browser: what is asked for, and what is not."""

import asyncio

import numpy as np
import pytest

from rst_control.simulation.rendering.painter import png_bytes
from support.browser import MISSING, Browser, find_browser
from tests.support.page import click, click_picture, enter, text
from tests.unit.voice_assist.display.support.theatre import (
    PULLING,
    TISSUE,
    TOKEN,
    Clock,
    RecordedActs,
    make_server,
    make_theatre,
)
from voice_assist.display.snapshot import UtterancePart

pytestmark = pytest.mark.skipif(not find_browser(), reason=MISSING)
STAMP = 1795676782.123456789  # [s] of the picture that is clicked
MARKS = """const later = window.setTimeout, never = window.clearTimeout;
window.marks = new Set();
window.setTimeout = (done, after) => {
  const timer = later(done, after);
  if (after === 6000) window.marks.add(timer);
  return timer;
};
window.clearTimeout = (timer) => { window.marks.delete(timer); never(timer); };"""
UNSURE = UtterancePart(" Pull more.", "", "nearly sure", "recognizer")


async def use(page, theatre, acts):
    """Answer a question without a token, and with it; one answer is "no"."""
    async with Browser() as browser:
        await browser.open(page)
        theatre.see_robot(PULLING, TISSUE)
        await browser.until("document.getElementById('question').hidden")
        theatre.answer_within = 100.0
        theatre.see_utterance(UNSURE, "pull more")
        await browser.until("!document.getElementById('question').hidden")
        assert "pull more?" in await browser.evaluate(text("question-words"))
        await browser.evaluate(click("yes"))
        await browser.until(f"{text('act-words')}.includes('Enter the token')")
        assert acts.asked == []
        for token in ("WRONGONE", TOKEN):
            await browser.evaluate(enter(token))
            await browser.evaluate(click("yes"))
            wanted = "done" if token == TOKEN else "the token is wrong"
            await browser.until(f"{text('act-words')}.includes({wanted!r})")
        await browser.evaluate(click("no"))
        await browser.until("true")
        while len(acts.asked) < 2:
            await asyncio.sleep(0.01)
        theatre.see_utterance(UNSURE)  # the next decision ends the question
        await browser.until("document.getElementById('question').hidden")


def test_a_question_is_answered_after_the_token():
    theatre, acts = make_theatre(), RecordedActs()

    async def run():
        async with make_server(theatre, acts) as server:
            await use(server.address, theatre, acts)

    asyncio.run(run())
    assert acts.asked == [("answer", "pull more", True), ("answer", "pull more", False)]


@pytest.mark.parametrize("wrong", ["ТОКЕН", "ABCDEFG\u2013", "ÄBCDEFGH"])
def test_a_token_that_cannot_be_sent_is_refused_where_it_is_entered(wrong):
    acts = RecordedActs()

    async def use(page):
        async with Browser() as browser:
            await browser.open(page)
            await browser.evaluate(enter(TOKEN))
            await browser.evaluate(enter(wrong))
            assert "letters A to Z and digits" in await browser.evaluate(text("act-words"))
            await browser.evaluate("document.getElementById('microphone-name').value = 'usb'")
            await browser.evaluate(click("choose"))  # by the token before it
            await browser.until(f"{text('act-words')} === 'done'")

    async def run():
        async with make_server(None, acts) as server:
            await use(server.address)

    asyncio.run(run())
    assert acts.asked == [("microphone", "usb")]


def test_the_mark_of_a_second_click_lasts_as_long_as_that_of_the_first():
    async def run():
        async with make_server() as server, Browser() as browser:
            await browser.send("Page.addScriptToEvaluateOnNewDocument", source=MARKS)
            await browser.open(server.address)
            for x in (10, 20):
                await browser.evaluate(f"markPick({{ clientX: {x}, clientY: 10 }})")
            assert await browser.evaluate("window.marks.size") == 1

    asyncio.run(run())


async def pick(page, theatre, acts, clock):
    """Click into a picture that became old meanwhile, and into the next one."""
    picture = png_bytes(np.zeros((80, 120, 3), np.uint8))
    async with Browser() as browser:
        await browser.open(page)
        theatre.see_picture("image/png", picture, 10.0)
        await browser.until("document.getElementById('picture').naturalWidth === 120")
        await browser.evaluate(enter(TOKEN))
        await browser.evaluate(click("pick"))
        theatre.see_picture("image/png", picture, 20.0)
        clock.now += 1000.0
        await browser.until(f"{text('picture-words')}.startsWith('OLD')")
        await browser.evaluate(click_picture(0.25, 0.5))
        assert "That picture is old" in await browser.evaluate(text("pick-words"))
        assert acts.asked == []
        theatre.see_picture("image/png", picture, STAMP)
        await browser.until(f"{text('picture-words')}.startsWith('Picture')")
        await browser.evaluate(click_picture(0.25, 0.5))
        await browser.until(f"{text('pick-words')} === 'Set: done'")
        await browser.evaluate(click_picture(0.75, 0.5))  # no longer armed
        assert await browser.evaluate(text("pick-words")) == "Set: done"


def test_a_click_counts_in_a_fresh_picture_alone_and_is_not_lost_in_an_old_one():
    clock, acts = Clock(), RecordedActs()
    theatre = make_theatre(clock)
    theatre.see_picture_period(300.0)

    async def run():
        async with make_server(theatre, acts) as server:
            await pick(server.address, theatre, acts, clock)

    asyncio.run(run())
    (asked,) = acts.asked
    assert asked[0] == "grasp"
    assert asked[1:3] == pytest.approx((0.25, 0.5), abs=0.01)
    assert asked[3] == STAMP  # of the picture that was clicked
