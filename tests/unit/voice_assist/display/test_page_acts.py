# SPDX-License-Identifier: BSD-3-Clause
"""What a person does on the page, in a headless browser: what is asked for, and what is not."""

import asyncio

import pytest

from support.browser import MISSING, Browser, find_browser
from tests.unit.voice_assist.display.support.theatre import (
    PULLING,
    TISSUE,
    TOKEN,
    RecordedActs,
    make_server,
    make_theatre,
)
from voice_assist.display.snapshot import UtterancePart

pytestmark = pytest.mark.skipif(not find_browser(), reason=MISSING)
UNSURE = UtterancePart(" Pull more.", "", "nearly sure", "recognizer")


def click(name):
    return f"document.getElementById('{name}').click()"


def text(name):
    return f"document.getElementById('{name}').textContent"


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
            await browser.evaluate(f"document.getElementById('token').value = {token!r}")
            await browser.evaluate("document.getElementById('unlock').requestSubmit()")
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
