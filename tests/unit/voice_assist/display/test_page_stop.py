# SPDX-License-Identifier: BSD-3-Clause
"""What the page says below STOP and in its alarm band, in a headless browser."""

import asyncio
import threading
from dataclasses import replace

import numpy as np
import pytest

from rst_control.simulation.rendering.painter import png_bytes
from support.browser import MISSING, find_browser
from tests.support.page import click, enter, text
from tests.unit.voice_assist.display.support.served_page import use_page
from tests.unit.voice_assist.display.support.theatre import (
    HALTED,
    PULLING,
    STOPPED,
    TISSUE,
    TOKEN,
    RecordedActs,
    make_theatre,
)
from voice_assist.display.acts import Outcome

pytestmark = pytest.mark.skipif(not find_browser(), reason=MISSING)
REST = "Brakes and holds. Not an emergency stop."
WORDS = text("stop-words")
LATE_TEXTS = """const send = window.fetch;
window.fetch = (url, ...options) => url !== "/texts.json" ? send(url, ...options)
  : new Promise((answer) => { window.release = () => { answer(send(url, ...options)); }; });"""
OLD_BROWSER = """delete AbortSignal.timeout;
delete Element.prototype.replaceChildren;"""  # of 2022 and 2020
SILENT = """window.fetch = (url, { signal }) =>
  new Promise((_, refuse) => signal.addEventListener("abort", () => refuse(signal.reason)));"""
THROWS = "window.fetch = () => { throw new Error('of no use'); };"
COUNTED = """const send = window.fetch;
window.answers = 0;
window.fetch = async (url, ...options) => {
  const answer = await send(url, ...options);
  if (url === "/act/stop") window.answers += 1;
  return answer;
};"""


class Answers(RecordedActs):
    """Each stop is answered by the next of these; the first one waits for `is_free`."""

    def __init__(self, *outcomes, waits=False):
        super().__init__()
        self.outcomes, self.is_free = list(outcomes), threading.Event()
        if not waits:
            self.is_free.set()

    def stop(self):
        outcome, is_first = self.outcomes.pop(0), not self.asked
        self.asked.append("stop")
        if is_first:
            self.is_free.wait(3.0)
        return outcome

    def send_stop(self):
        pass


def on_page(use, acts=None, script=""):
    """Do something on the page of a robot that moves."""
    theatre = make_theatre()

    async def use_it(browser, server):
        await browser.until(f"{text('state')} === 'Moving'")
        await use(browser, theatre)

    use_page(use_it, theatre, script, acts=acts)


async def show(browser, theatre, robot, state):
    theatre.see_robot(robot, TISSUE)
    await browser.until(f"{text('state')} === {state!r}")


def test_what_came_of_a_stop_stands_until_the_robot_was_halted_and_woken():
    async def use(browser, theatre):
        for words in ("stops", "NOT STOPPED: no. Press the emergency stop."):
            await browser.until(f"{WORDS} === {REST!r}")
            await browser.evaluate(click("stop"))
            await browser.until(f"{WORDS} === {words!r}")
            await show(browser, theatre, replace(PULLING, state="active"), "Ready")
            await show(browser, theatre, HALTED, "Halted")
            assert await browser.evaluate(WORDS) == words
            await asyncio.sleep(0.4)  # a press sooner is the same one
            await show(browser, theatre, PULLING, "Moving")
            assert await browser.evaluate(WORDS) == REST
            is_bad = "document.getElementById('stop-words').classList.contains('is-bad')"
            assert not await browser.evaluate(is_bad)

    on_page(use, Answers(Outcome(True, "stops"), Outcome(False, "no")))


def test_texts_that_come_late_do_not_overwrite_what_came_of_a_stop():
    async def use(browser, theatre):
        await browser.evaluate(click("stop"))
        await browser.until(f"{WORDS}.startsWith('NOT STOPPED: no')")
        await browser.evaluate("window.before = texts, window.release()")
        await browser.until("texts !== window.before")
        assert (await browser.evaluate(WORDS)).startswith("NOT STOPPED: no")

    on_page(use, Answers(Outcome(False, "no")), LATE_TEXTS)


def test_the_answer_of_an_older_press_is_dropped():
    acts = Answers(Outcome(False, "late"), Outcome(True, "stops"), waits=True)

    async def use(browser, theatre):
        await browser.evaluate(click("stop"))
        while not acts.asked:
            await asyncio.sleep(0.01)
        await asyncio.sleep(0.4)  # a press sooner is the same one
        await browser.evaluate(click("stop"))
        await browser.until(f"{WORDS} === 'stops'")
        acts.is_free.set()
        await browser.until("window.answers === 2")
        await asyncio.sleep(0.1)
        assert await browser.evaluate(WORDS) == "stops"

    on_page(use, acts, COUNTED)


def test_an_old_browser_sends_a_stop_and_shows_pictures():
    acts = Answers(Outcome(True, "stops"))

    async def use(browser, theatre):
        theatre.see_picture("image/png", png_bytes(np.zeros((80, 120, 3), np.uint8)), 10.0)
        await browser.until("document.getElementById('picture').naturalWidth === 120")
        assert await browser.evaluate(f"{text('words')}.includes('stop')")
        await browser.evaluate(click("stop"))
        await browser.until(f"{WORDS} === 'stops'")
        assert not browser.errors

    on_page(use, acts, OLD_BROWSER)
    assert acts.asked == ["stop"]


@pytest.mark.parametrize("fetch", [SILENT, THROWS], ids=["silent", "throws"])
def test_a_stop_that_nobody_answers_or_that_cannot_be_sent_is_no_stop(fetch):
    acts = Answers()

    async def use(browser, theatre):
        await browser.evaluate(fetch)
        await browser.evaluate(click("stop"))
        await browser.until(f"{WORDS} === 'NOT STOPPED: no answer. Press the emergency stop.'")

    on_page(use, acts, OLD_BROWSER)
    assert not acts.asked


def test_nothing_of_the_last_alarm_stands_where_no_alarms_are_watched():
    async def use(browser, theatre):
        theatre.see_alarm(replace(STOPPED, is_acknowledged=True, others=("tension: old",)))
        await browser.until(f"{text('alarm-others')}.includes('tension: old')")
        theatre.see_alarm(None)
        await browser.until(f"{text('alarm-cause')} === 'No alarms are watched'")
        assert await browser.evaluate(text("alarm-others")) == ""
        is_acknowledged = "document.getElementById('alarm').classList.contains('is-acknowledged')"
        assert not await browser.evaluate(is_acknowledged)

    on_page(use)


@pytest.mark.parametrize("where", ["in this window", "in another"])
def test_a_stop_has_a_connection_though_all_are_taken(where):
    """A browser has six to a server: four other windows, the page's own, and an act that lasts."""

    class Busy(Answers):
        def choose_microphone(self, name):
            self.asked.append(name)
            self.is_free.wait(8.0)
            return Outcome(True, "chosen")

    acts = Busy(Outcome(True, "stops"), waits=True)
    acts.asked.append("so that no stop is the first")

    async def use(browser, theatre):
        await browser.evaluate(enter(TOKEN))
        others = "window.others = [1, 2, 3, 4].map(() => new EventSource('/events'))"
        await browser.evaluate(others)
        await browser.until("window.others.every((one) => one.readyState === 1)")
        choose = "document.getElementById('microphone-name').value = 'usb'," + click("choose")
        await browser.evaluate(choose)
        while "usb" not in acts.asked:
            await asyncio.sleep(0.01)
        if where == "in another":
            await browser.evaluate("new BroadcastChannel('stop').postMessage('')")
            await browser.until("!underWay.size")
        await browser.evaluate(click("stop"))
        await browser.until(f"{WORDS} === 'stops'")
        assert not acts.is_free.is_set()
        acts.is_free.set()

    on_page(use, acts)
