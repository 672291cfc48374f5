# SPDX-License-Identifier: BSD-3-Clause
"""What the page's server refuses over real sockets, and its limits, without ROS."""

import asyncio
import random
import socket
import string
from contextlib import suppress

from support.waiting import PATIENCE
from tests.unit.voice_assist.display.support.served_page import assert_strict, first_event, run
from tests.unit.voice_assist.display.support.theatre import TOKEN, RecordedActs, make_theatre
from voice_assist.display import connections


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
        monkeypatch.setattr(connections, "ANSWER_WITHIN", PATIENCE)
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
        monkeypatch.setattr(connections, "ANSWER_WITHIN", PATIENCE)
        async with session.get("/") as answer:
            assert answer.status == 200

    run(act, acts=acts, errors=errors)
    assert not acts.asked and not errors
