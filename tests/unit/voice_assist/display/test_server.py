# SPDX-License-Identifier: BSD-3-Clause
"""The page's server over real sockets, without ROS."""

import asyncio
import json
import random
import socket
import string
import threading
import time
from contextlib import suppress

import pytest
from aiohttp import ClientSession, ClientTimeout, TCPConnector

from support.waiting import PATIENCE
from tests.unit.voice_assist.display.support.theatre import (
    TOKEN,
    Clock,
    RecordedActs,
    make_server,
    make_theatre,
)
from typed_config import load_file
from voice_assist.config.display import FILE, DisplayConfig
from voice_assist.display import connections
from voice_assist.display.acts import BadRequestError, read_act
from voice_assist.display.http_rules import HEADERS
from voice_assist.display.server import AT_WORK, FILES, MOST_BODY, STAMP

LIMIT = ClientTimeout(PATIENCE)
RIGHT = {"Authorization": f"Bearer {TOKEN}"}


def run(act, **settings):
    """Let `act(server, session)` use a page; gives what it returns."""

    async def inner():
        connector = TCPConnector(limit=0)
        async with (
            make_server(**settings) as server,
            ClientSession(server.address, timeout=LIMIT, connector=connector) as session,
        ):
            return await act(server, session)

    return asyncio.run(inner())


def assert_strict(headers):
    for name, value in HEADERS.items():
        assert headers.get(name) == value, name
    assert headers.get("Connection", "close") == "close"  # HTTP/1.0 ends by itself


async def first_event(response):
    line = await response.content.readline()
    return json.loads(line.removeprefix(b"data: "))


async def next_event(response):
    """Its line; an empty one follows."""
    line = await response.content.readline()
    await response.content.readline()
    return line


def test_page_style_and_script_are_served_from_the_package():
    async def act(_, session):
        for path, (name, kind) in FILES.items():
            async with session.get(path) as answer:
                assert answer.status == 200, name
                assert answer.content_type == kind
                assert_strict(answer.headers)
                assert b"SPDX" in await answer.read()
        async with session.head("/") as answer:
            assert answer.status == 200 and not await answer.read()

    run(act)


def test_no_file_asks_for_anything_from_elsewhere():
    async def act(_, session):
        for path in FILES:
            async with session.get(path) as answer:
                text = (await answer.text()).replace("http://www.w3.org/2000/svg", "")
                assert "http:" not in text and "https:" not in text and "//cdn" not in text

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


def test_a_stop_needs_no_token_and_is_sent_whatever_comes_with_it():
    acts = RecordedActs()

    async def act(_, session):
        for body in (b"", b"{", b"\xff" * 5000):
            async with session.post("/act/stop", data=body) as answer:
                assert answer.status == 200
                assert await answer.json() == {"done": True, "words": "done"}
                assert_strict(answer.headers)

    run(act, acts=acts)
    assert acts.asked == ["sent stop", "stop"] * 3


def test_a_stop_is_sent_while_all_that_acts_is_busy():
    is_over = threading.Event()

    class Slow(RecordedActs):
        def stop(self):
            assert is_over.wait(PATIENCE)
            return super().stop()

    acts = Slow()

    async def act(_, session):
        posts = (session.post("/act/stop") for _ in range(AT_WORK + 3))
        refused, waiting = set(), set(map(asyncio.ensure_future, posts))
        while len(refused) < 3:
            done, waiting = await asyncio.wait(waiting, return_when=asyncio.FIRST_COMPLETED)
            refused |= done
        is_over.set()
        assert {answer.result().status for answer in refused} == {503}
        assert {answer.status for answer in await asyncio.gather(*waiting)} == {200}

    run(act, acts=acts)
    assert acts.asked.count("sent stop") == AT_WORK + 3


def test_a_stop_is_confirmed_while_other_acts_keep_all_threads_busy():
    is_over = threading.Event()

    class Slow(RecordedActs):
        def choose_microphone(self, name):
            assert is_over.wait(PATIENCE)
            return super().choose_microphone(name)

    async def act(_, session):
        body, count = {"name": "USB"}, AT_WORK + 1
        choose = (session.post("/act/microphone", json=body, headers=RIGHT) for _ in range(count))
        refused, waiting = set(), set(map(asyncio.ensure_future, choose))
        while not refused:
            done, waiting = await asyncio.wait(waiting, return_when=asyncio.FIRST_COMPLETED)
            refused |= done
        async with session.post("/act/stop") as answer:
            assert answer.status == 200 and (await answer.json())["done"]
        is_over.set()
        await asyncio.gather(*waiting)

    run(act, acts=Slow())


def test_a_microphone_is_chosen_with_the_token_only():
    acts, body = RecordedActs(), {"name": "USB"}

    async def act(_, session):
        for headers in ({}, {"Authorization": "Bearer WRONG"}, {"Authorization": "Basic x"}):
            async with session.post("/act/microphone", json=body, headers=headers) as answer:
                assert answer.status == 401
                assert_strict(answer.headers)
        assert not acts.asked
        async with session.post("/act/microphone", json=body, headers=RIGHT) as answer:
            assert (answer.status, await answer.json()) == (200, {"done": True, "words": "done"})

    run(act, acts=acts)
    assert acts.asked == [("microphone", "USB")]


@pytest.mark.parametrize(
    "body",
    [
        b"",
        b"[]",
        b'{"name": ""}',
        b'{"name": "a\\u0000"}',
        b'{"name": 3}',
        b'{"name": "a", "more": 1}',
        b"x" * (MOST_BODY + 1),
        b"[" * MOST_BODY,
    ],
)
def test_what_is_asked_for_badly_is_named_and_does_nothing(body):
    acts = RecordedActs()

    async def act(_, session):
        async with session.post("/act/microphone", data=body, headers=RIGHT) as answer:
            assert answer.status == 400
            assert (await answer.text()).strip()
            assert_strict(answer.headers)

    run(act, acts=acts)
    assert not acts.asked


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"x": 1.0}, "x is a share of the picture, from 0 up to below 1"),
        ({"y": -0.1}, "y is a share"),
        ({"y": True}, "y is a share"),
        ({"stamp": None}, "stamp is when the picture was taken, in seconds from 0 on"),
        ({"stamp": -1.0}, "stamp is when"),
        ({"stamp": float("inf")}, "stamp is when"),
        ({"z": 0.0}, "grasp takes x, y, stamp, and nothing else"),
    ],
)
def test_a_click_is_three_numbers(wrong, words):
    right = {"x": 0.5, "y": 0.0, "stamp": 7}
    acts = RecordedActs()
    read_act("grasp", json.dumps(right).encode())(acts)
    assert acts.asked == [("grasp", 0.5, 0.0, 7.0)]
    with pytest.raises(BadRequestError, match=words):
        read_act("grasp", json.dumps({**right, **wrong}).encode())


def test_an_act_that_fails_is_logged_and_answered():
    class Broken(RecordedActs):
        def choose_microphone(self, name):
            raise RuntimeError("broken")

    errors = []

    async def act(_, session):
        async with session.post("/act/microphone", json={"name": "USB"}, headers=RIGHT) as answer:
            assert (await answer.json())["done"] is False

    run(act, acts=Broken(), errors=errors)
    assert "broken" in errors[0]


def test_other_names_and_other_pages_are_refused():
    acts = RecordedActs()

    async def act(server, session):
        port = server.address.rsplit(":", 1)[1]
        bad = (
            {"Host": "theatre.example"},
            {"Host": f"theatre.example:{port}"},
            {"Host": "127.0.0.1"},
            {"Host": ""},
            {"Origin": "http://theatre.example"},
            {"Origin": f"https://127.0.0.1:{port}"},
            {"Origin": "null"},
        )
        for headers in bad:
            for path in ("/", "/events", "/act/stop"):
                method = "POST" if "act" in path else "GET"
                async with session.request(method, path, headers=headers) as answer:
                    assert answer.status == 403, headers
                    assert_strict(answer.headers)
        assert not acts.asked
        for host in (f"localhost:{port}", f"OR-2.local:{port}"):
            async with session.get("/", headers={"Host": host}) as answer:
                assert answer.status == 200
        own = {"Origin": server.address}
        async with session.post("/act/stop", headers=own) as answer:
            assert answer.status == 200

    run(act, acts=acts, hosts=("or-2.local",))


def test_unknown_paths_and_methods_are_named():
    async def act(_, session):
        cases = {
            ("GET", "/nothing"): 404,
            ("GET", "/page/../server.py"): 404,
            ("GET", "/%2e%2e/server.py"): 404,
            ("POST", "/"): 405,
            ("DELETE", "/events"): 405,
            ("GET", "/act/stop"): 405,
            ("POST", "/act/tense"): 404,
        }
        for (method, path), status in cases.items():
            async with session.request(method, path) as answer:
                assert answer.status == status, path
                assert_strict(answer.headers)

    run(act)


def test_one_viewer_too_many_is_refused_and_a_place_becomes_free():
    async def act(server, session):
        first = [await session.get("/events") for _ in range(2)]
        async with session.get("/events") as answer:
            assert answer.status == 503
            assert_strict(answer.headers)
        first[0].close()
        while len(server.viewers) == 2:
            await asyncio.sleep(0.01)
        async with session.get("/events") as answer:
            assert answer.status == 200

    run(act, max_viewers=2)


def test_a_hundred_viewers_all_see_it():
    async def act(server, session):
        answers = await asyncio.gather(*(session.get("/events") for _ in range(100)))
        data = await asyncio.gather(*(first_event(answer) for answer in answers))
        assert len(server.viewers) == 100
        assert all(entry["robot"]["state"] == "moving" for entry in data)
        async with session.post("/act/stop") as answer:
            assert answer.status == 200
        for answer in answers:
            answer.close()

    run(act)


def test_a_viewer_that_never_reads_is_dropped_and_delays_nobody():
    theatre = make_theatre()
    theatre.see_partial("x" * 60_000)  # large events, so that what waits is soon full

    async def act(server, session):
        port = int(server.address.rsplit(":", 1)[1])
        asleep = socket.socket()
        asleep.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        asleep.setblocking(False)
        loop = asyncio.get_running_loop()
        await loop.sock_connect(asleep, ("127.0.0.1", port))
        request = f"GET /events HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n"
        await loop.sock_sendall(asleep, request.encode())
        async with session.get("/events") as awake:
            while len(server.viewers) < 2:
                await asyncio.sleep(0.01)
            count = 0
            while len(server.viewers) > 1:
                await awake.content.readline()
                await awake.content.readline()
                count += 1
            assert count > 4, "it waited for the one that does not read"
            assert (await first_event(awake))["robot"]
        asleep.close()

    run(act, theatre=theatre, rate=30.0, backlog=4)


def test_a_connection_that_says_nothing_or_too_little_ends(monkeypatch):
    monkeypatch.setattr(connections, "ANSWER_WITHIN", 0.2)

    async def act(server, _):
        port = int(server.address.rsplit(":", 1)[1])
        for words in (b"", b"GET / HTTP/1.1\r\nHost: a", b"POST /act/microphone HTTP/1.1\r\n"):
            reader, writer = await asyncio.open_connection("127.0.0.1", port)
            writer.write(words)
            with suppress(ConnectionResetError):
                assert await asyncio.wait_for(reader.read(), PATIENCE) == b""
            writer.close()

    run(act)


def test_connections_without_end_leave_room_for_none_but_are_bounded(monkeypatch):
    monkeypatch.setattr(connections, "ANSWER_WITHIN", 0.5)
    monkeypatch.setattr(connections, "SPARE", 5)

    async def act(server, session):
        port = int(server.address.rsplit(":", 1)[1])
        idle = [await asyncio.open_connection("127.0.0.1", port) for _ in range(30)]
        ended = 0
        for reader, _ in idle:
            try:
                ended += await asyncio.wait_for(reader.read(), PATIENCE) == b""
            except ConnectionResetError:
                ended += 1
        assert ended == 30
        async with session.get("/") as answer:
            assert answer.status == 200

    run(act, max_viewers=2)


def test_garbage_is_answered_strictly_or_not_at_all(monkeypatch):
    """Drawn requests: broken lines, methods, paths, headers; none does anything."""
    monkeypatch.setattr(connections, "ANSWER_WITHIN", 0.3)
    acts, errors, draw = RecordedActs(), [], random.Random(33)
    letters = string.printable + "\x00\x7f\xff"

    def words(most):
        return "".join(draw.choice(letters) for _ in range(draw.randrange(most)))

    def one_of(*good):
        return draw.choice(good) if draw.random() < 0.85 else words(30)

    def request(port):
        method = one_of("GET", "POST", "PUT", "OPTIONS", "TRACE", "CONNECT")
        path = one_of("/", "/events?x", "/picture", "/act/microphone", "/act/x")
        version, host = one_of("HTTP/1.1", "HTTP/1.0"), one_of(f"127.0.0.1:{port}")
        length = one_of("", "", "Content-Length: 5\r\n", "Transfer-Encoding: chunked\r\n")
        token = one_of("", f"Authorization: Bearer {TOKEN}\r\n")
        head = f"{method} {path} {version}\r\nHost: {host}\r\n{length}{token}\r\n"
        return (head + words(200)).encode("latin-1", "replace")

    async def ask(port, data):
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        try:
            writer.write(data)
            return await asyncio.wait_for(reader.read(4096), 20.0)
        except (ConnectionError, OSError):
            return b""
        finally:
            writer.close()

    async def act(server, session):
        port = int(server.address.rsplit(":", 1)[1])
        statuses = set()
        for _ in range(40):
            answers = await asyncio.gather(*(ask(port, request(port)) for _ in range(25)))
            for answer in filter(None, answers):
                head = answer.split(b"\r\n\r\n")[0].decode("latin-1").split("\r\n")
                found = dict(line.split(": ", 1) for line in head[1:])
                statuses.add(int(head[0].split()[1]))
                assert_strict(found)
        assert statuses <= {200, 400, 401, 403, 404, 405, 429}, statuses
        assert {400, 403, 404, 405} <= statuses
        async with session.get("/") as answer:
            assert answer.status == 200

    run(act, acts=acts, errors=errors)
    assert not acts.asked and not errors
