# SPDX-License-Identifier: BSD-3-Clause
"""The page with all words that can be said, on every screen and in both themes."""

import asyncio
from dataclasses import replace

import pytest

from support.browser import MISSING, Browser, find_browser
from tests.unit.voice_assist.display.support.theatre import (
    HALTED,
    PULLING,
    STOPPED,
    TISSUE,
    make_server,
    make_theatre,
)
from typed_config import load_config, load_yaml
from voice_assist.config import CONFIG_DIR, load_voice_config
from voice_assist.config.commands import ENGLISH, LANGUAGES, CommandsConfig
from voice_assist.display.snapshot import UtterancePart
from voice_assist.ros.display.messages import word_rules

SCREENS = ((1920, 1080), (390, 844))  # [pixels]: in the theatre, and a telephone
TOO_WIDE = """document.documentElement.scrollWidth <= innerWidth ? [] :
    [...document.querySelectorAll('*')].filter((e) =>
        e.getBoundingClientRect().right > innerWidth + 1).map((e) => e.id || e.tagName)"""
CUT_OFF = """[...document.querySelectorAll('h1, p, span, strong, small, button')].filter((e) =>
    e.offsetParent && getComputedStyle(e).display !== 'inline'
    && getComputedStyle(e).textOverflow !== 'ellipsis' && e.scrollWidth > e.clientWidth + 1
).map((e) => e.id || e.textContent)"""
OUT_OF_ITS_BAND = """[...document.querySelectorAll('.part')].flatMap((part) =>
    [...part.querySelectorAll('*')].filter((e) => e.offsetParent && !e.closest('.stop, .mark')
        && e.getBoundingClientRect().bottom > part.getBoundingClientRect().bottom + 1
    ).map((e) => e.id || e.textContent))"""
UNDER_THE_EDGE = "innerWidth < 900 ? 0 : document.documentElement.scrollHeight - innerHeight"
BACKGROUND = "getComputedStyle(document.body).backgroundColor"
WORDS = "[...document.querySelectorAll('#words b')].map((e) => e.textContent)"
UNTRANSLATED = """(() => {
    const known = new Set(Object.keys(texts).filter((e) => texts[e] !== e)), left = [];
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    while (walker.nextNode()) {
        if (known.has(walker.currentNode.data.trim())) left.push(walker.currentNode.data);
    }
    return left;
})()"""


def everything_that_can_be_said():
    """Commands of a theatre with devices, and amounts."""
    theatre = load_config(CommandsConfig, load_yaml(CONFIG_DIR / "theatre_commands.yaml"))
    return [*theatre.commands, *load_voice_config(commands__amounts=True).commands.commands]


def busy_theatre(robot, alarm=None):
    """Everything is shown at once; with an alarm a question, too."""
    theatre = make_theatre()
    theatre.rules = word_rules(everything_that_can_be_said())
    theatre.see_robot(robot, TISSUE)
    if alarm is not None:
        theatre.answer_within = 600.0
        why = 'heard the words of "pull two millimetres more", but too unsurely to be taken'
        theatre.see_utterance(UtterancePart(" Pull two millimetres.", "", why, ""), "pull more")
        others = ("recording: recorder silent for 1.2 s", "pedal: unplugged, looked for again") * 2
        theatre.see_alarm(replace(alarm, is_acknowledged=True, others=others))
    return theatre


async def look(theatre, language=ENGLISH):
    """Faults of each screen and theme, the colours behind, and the words that count."""
    faults, backgrounds = [], set()
    async with Browser() as browser, make_server(theatre, language=language) as server:
        await browser.open(server.address, *SCREENS[0])
        await browser.until(f"document.documentElement.lang === {language!r} && news !== null")
        await browser.until("document.getElementById('robot').dataset.state !== undefined")
        words = await browser.evaluate(WORDS)
        for screen in SCREENS:
            for theme in ("light", "dark"):
                await browser.set_screen(*screen, theme)
                for script in (TOO_WIDE, CUT_OFF, OUT_OF_ITS_BAND, UNDER_THE_EDGE, UNTRANSLATED):
                    if found := await browser.evaluate(script):
                        faults.append((*screen, theme, found))
                backgrounds.add((theme, await browser.evaluate(BACKGROUND)))
    return faults, backgrounds, words


@pytest.mark.skipif(not find_browser(), reason=MISSING)
@pytest.mark.parametrize(
    "parts",
    [
        (replace(PULLING, command="pull more 2 mm"),),
        (replace(PULLING, state="active", command="pull more 2 mm"),),
        (replace(HALTED, halt_reason="stopped by /display"), STOPPED),
    ],
    ids=["moving", "ready", "halted"],
)
def test_every_band_holds_all_of_it_on_every_screen_in_every_theme(parts):
    faults, backgrounds, words = asyncio.run(look(busy_theatre(*parts)))
    assert faults == []
    assert len({colour for _, colour in backgrounds}) == 2
    assert "stop" in words and "save this" in words
    assert "pull … more" in words or parts[0].state == "halted"


@pytest.mark.skipif(not find_browser(), reason=MISSING)
@pytest.mark.parametrize("language", LANGUAGES[1:])
def test_every_band_holds_the_words_of_another_language_and_none_stays_english(language):
    theatre = busy_theatre(replace(HALTED, halt_reason="stopped by /display"), STOPPED)
    theatre.rules = word_rules(load_voice_config(language=language).commands.commands)
    faults, _, words = asyncio.run(look(theatre, language))
    assert faults == []
    assert "stop" in words
