# SPDX-License-Identifier: BSD-3-Clause
"""What a person does on the page, in a headless browser: what is asked for, and what is not."""

import asyncio

import numpy as np
import pytest

from rst_control.simulation.rendering.painter import png_bytes
from support.browser import MISSING, find_browser
from tests.support.page import click, click_picture, enter, text
from tests.unit.voice_assist.display.support.served_page import use_page
from tests.unit.voice_assist.display.support.theatre import (
    PULLING,
    TISSUE,
    TOKEN,
    Clock,
    RecordedActs,
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
READ = "performance.now() - asked >= READ_WITHIN"  # the question was there long enough
PRESS = """((e) => { e.dispatchEvent(new PointerEvent("pointerdown"));
window.release = () => e.dispatchEvent(new MouseEvent("click", {detail: 1, bubbles: true}));
})(document.getElementById("yes"))"""
UNSURE = UtterancePart(" Pull more.", "", "nearly sure", "recognizer")


def test_a_question_is_answered_after_the_token():
    """One answer is "no". A second press, as of a double tap, is none."""
    theatre, acts = make_theatre(), RecordedActs()

    async def use(browser, server):
        theatre.see_robot(PULLING, TISSUE)
        await browser.until("document.getElementById('question').hidden")
        theatre.answer_within = 100.0
        theatre.see_utterance(UNSURE, "pull more")
        await browser.until("!document.getElementById('question').hidden")
        assert "pull more?" in await browser.evaluate(text("question-words"))
        await browser.evaluate(click("yes"))
        await browser.until(f"{text('act-words')}.includes('Enter the token')")
        assert acts.asked == []
        await browser.until(READ)
        for token in ("WRONGONE", TOKEN):
            await browser.evaluate(enter(token))
            await browser.evaluate(f"{click('yes')}, {click('yes')}, {click('no')}")
            wanted = "done" if token == TOKEN else "the token is wrong"
            await browser.until(f"{text('act-words')}.includes({wanted!r})")
        await browser.evaluate(click("no"))  # it was answered
        theatre.see_utterance(UNSURE)  # the next decision ends the question
        await browser.until("document.getElementById('question').hidden")
        theatre.see_utterance(UNSURE, "pull more")
        await browser.until("!document.getElementById('question').hidden")
        await browser.evaluate(click("no"))
        while len(acts.asked) < 2:
            await asyncio.sleep(0.01)

    use_page(use, theatre, acts=acts)
    assert acts.asked == [("answer", "pull more", True), ("answer", "pull more", False)]


@pytest.mark.parametrize("is_held", [False, True])
def test_a_yes_to_another_question_than_was_read_moves_nothing(is_held):
    """A finger goes down on one question, or nearly; it is lifted on the next."""
    theatre, acts = make_theatre(), RecordedActs()

    async def use(browser, server):
        theatre.see_robot(PULLING, TISSUE)
        theatre.answer_within = 100.0
        await browser.evaluate(enter(TOKEN))
        theatre.see_utterance(UNSURE, "pull less")
        await browser.until(f"{text('question-words')}.startsWith('pull less?')")
        await browser.until(READ)
        await browser.evaluate(PRESS)
        theatre.see_utterance(UNSURE, "pull more")
        await browser.until(f"{text('question-words')}.startsWith('pull more?')")
        if is_held:
            await browser.until(READ)
        await browser.evaluate("window.release()")
        await browser.until(f"{text('act-words')}.includes('has just changed')")
        assert acts.asked == []
        await browser.until(READ)
        await browser.evaluate(f"{PRESS}, window.release()")
        while not acts.asked:
            await asyncio.sleep(0.01)

    use_page(use, theatre, acts=acts)
    assert acts.asked == [("answer", "pull more", True)]


def test_a_token_that_cannot_be_sent_is_refused_where_it_is_entered():
    acts, wrong_ones = RecordedActs(), ("ТОКЕН", "ABCDEFG\u2013", "ÄBCDEFGH")

    async def use(browser, server):
        await browser.evaluate(enter(TOKEN))
        for wrong in wrong_ones:
            await browser.evaluate(enter(wrong))
            assert "letters A to Z and digits" in await browser.evaluate(text("act-words"))
            await browser.evaluate("document.getElementById('microphone-name').value = 'usb'")
            await browser.evaluate(click("choose"))  # by the token before it
            await browser.until(f"{text('act-words')} === 'done'")

    use_page(use, acts=acts)
    assert acts.asked == [("microphone", "usb")] * len(wrong_ones)


def test_the_mark_of_a_second_click_lasts_as_long_as_that_of_the_first():
    async def use(browser, server):
        for x in (10, 20):
            await browser.evaluate(f"markPick({{ clientX: {x}, clientY: 10 }})")
        assert await browser.evaluate("window.marks.size") == 1

    use_page(use, script=MARKS)


def test_a_click_counts_in_a_fresh_picture_alone_and_is_not_lost_in_an_old_one():
    clock, acts = Clock(), RecordedActs()
    theatre, picture = make_theatre(clock), png_bytes(np.zeros((80, 120, 3), np.uint8))
    theatre.see_picture_period(300.0)

    async def use(browser, server):
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

    use_page(use, theatre, acts=acts)
    (asked,) = acts.asked
    assert asked[0] == "grasp"
    assert asked[1:3] == pytest.approx((0.25, 0.5), abs=0.01)
    assert asked[3] == STAMP  # of the picture that was clicked
