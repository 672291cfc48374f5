# SPDX-License-Identifier: BSD-3-Clause
"""What the page's server serves over real sockets, without ROS."""

import asyncio
import time

from tests.unit.voice_assist.display.support.served_page import (
    assert_strict,
    first_event,
    next_event,
    run,
)
from tests.unit.voice_assist.display.support.theatre import Clock, make_theatre
from typed_config import load_file
from voice_assist.config.display import FILE, DisplayConfig
from voice_assist.display.server import FILES, STAMP


def test_page_style_and_script_are_served_from_the_package_and_ask_for_nothing_elsewhere():
    async def act(_, session):
        for path, (name, kind) in FILES.items():
            async with session.get(path) as answer:
                assert answer.status == 200, name
                assert answer.content_type == kind
                assert_strict(answer.headers)
                text = (await answer.text()).replace("http://www.w3.org/2000/svg", "")
                assert "SPDX" in text
                assert not [far for far in ("http:", "https:", "//cdn") if far in text]
        async with session.head("/") as answer:
            assert answer.status == 200 and not await answer.read()

    run(act)


def test_every_viewer_gets_the_same_events_at_the_rate():
    theatre, times = make_theatre(), []
    snapshot = theatre.snapshot
    theatre.snapshot = lambda: times.append(time.monotonic()) or snapshot()

    async def act(server, session):
        answers = [await session.get("/events") for _ in range(3)]
        for answer in answers:
            assert_strict(answer.headers)
            assert answer.content_type == "text/event-stream"
        assert len(server.viewers) == 3
        newest = await next_event(answers[-1])
        for answer in answers[:-1]:  # which came earlier
            while await next_event(answer) != newest:
                pass
        for _ in range(4):
            assert len({await next_event(answer) for answer in answers}) == 1
        for answer in answers:
            answer.close()
        while len(server.viewers):
            await asyncio.sleep(0.01)

    run(act, theatre=theatre)
    rate = load_file(DisplayConfig, FILE).rate
    assert len(times) <= (times[-1] - times[0]) * rate + 2  # a late one is followed at once


def test_old_news_come_with_their_age():
    clock = Clock()
    theatre = make_theatre(clock)
    clock.now += 7.25

    async def act(_, session):
        async with session.get("/events") as answer:
            data = await first_event(answer)
        assert data["robot"]["age"] == data["hearing"]["age"] == 7.25
        assert data["old_after"] == 0.5

    run(act, theatre=theatre)


def test_pictures_come_as_they_are():
    theatre = make_theatre()

    async def act(_, session):
        async with session.get("/picture") as answer:
            assert answer.status == 404
        theatre.see_picture("image/jpeg", b"\xff\xd8\xff", 1795676782.123456789)
        async with session.get("/picture") as answer:
            assert (answer.content_type, await answer.read()) == ("image/jpeg", b"\xff\xd8\xff")
            assert float(answer.headers[STAMP]) == 1795676782.123456789
            assert_strict(answer.headers)

    run(act, theatre=theatre)
