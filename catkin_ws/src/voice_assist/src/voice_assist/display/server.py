# SPDX-License-Identifier: BSD-3-Clause
"""Serves the page: four files and its texts, the picture, one stream of events, four acts."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

from aiohttp import web

from voice_assist.config.display import DisplayConfig
from voice_assist.config.texts import page_texts
from voice_assist.display.access_token import AccessToken
from voice_assist.display.acts import FORMS, STOP, Acts, BadRequestError, Outcome, read_act
from voice_assist.display.connections import Connection, Connections
from voice_assist.display.encoding import event
from voice_assist.display.http_rules import HostRules, answer, strict
from voice_assist.display.theatre import Theatre
from voice_assist.display.viewers import Viewer, Viewers

PAGE = Path(__file__).with_name("page")
FILES = {
    "/": ("index.html", "text/html"),
    "/page.css": ("page.css", "text/css"),
    "/page.js": ("page.js", "text/javascript"),
    "/texts.js": ("texts.js", "text/javascript"),
}
TEXTS = "/texts.json"  # of the page's language
STAMP = "Picture-Stamp"  # header: [s] when it was taken; a click into the picture names it
MOST_BODY = 2048  # [B] of an act
AT_WORK = 4  # acts at once
ENDS_WITHIN = 1.0  # [s] for answers under way when the server ends

Answer = web.StreamResponse


class Workers:
    """Threads that carry out what is asked for on the page.

    Args:
        name: Of the threads.
    """

    def __init__(self, name: str) -> None:
        self._threads, self._at_work = ThreadPoolExecutor(AT_WORK, name), 0

    @property
    def are_busy(self) -> bool:
        """Each has an act at work."""
        return self._at_work >= AT_WORK

    async def run(self, act: Callable[[Acts], Outcome], acts: Acts) -> Outcome:
        """Carry out an act; what it raises comes through."""
        self._at_work += 1
        try:
            return await asyncio.get_running_loop().run_in_executor(self._threads, act, acts)
        finally:
            self._at_work -= 1

    def close(self) -> None:
        """Wait for none of them."""
        self._threads.shutdown(wait=False, cancel_futures=True)


class DisplayServer:
    """The page at one address, as an asynchronous context.

    Args:
        config: Address, rate and limits.
        theatre: What is shown.
        acts: What a person may do.
        token: That all acts but "stop" need.
        on_error: Given, in words, what fails while an act is carried out.
    """

    def __init__(
        self,
        config: DisplayConfig,
        theatre: Theatre,
        acts: Acts,
        token: AccessToken,
        on_error: Callable[[str], None],
    ) -> None:
        self._config, self._theatre, self._acts = config, theatre, acts
        self._token, self._on_error = token, on_error
        self._files = {
            path: (kind, PAGE.joinpath(name).read_bytes()) for path, (name, kind) in FILES.items()
        }
        texts = {"language": config.language, "texts": page_texts(config.language)}
        self._files[TEXTS] = "application/json", json.dumps(texts).encode()
        self.viewers = Viewers(config.max_viewers, config.backlog)
        self._workers = Workers("act")
        self._stop_workers = Workers("stop")  # its own: no other act keeps a stop waiting
        self._runner: web.ServerRunner | None = None
        self._rules: HostRules | None = None
        self._ticks: asyncio.Task[None] | None = None
        self.address = ""  # of the page, once it is served

    async def __aenter__(self) -> DisplayServer:
        """Begin to serve.

        Raises:
            OSError: The address cannot be had.
        """
        config = self._config
        runner = self._runner = web.ServerRunner(
            Connections(self._handle, config.max_viewers), shutdown_timeout=ENDS_WITHIN
        )
        await runner.setup()
        await web.TCPSite(runner, config.address, config.port).start()
        port = int(runner.addresses[0][1])
        shown = f"[{config.address}]" if ":" in config.address else config.address
        self.address = f"http://{shown}:{port}"
        self._rules = HostRules(config.address, port, config.hosts)
        self._ticks = asyncio.create_task(self._run_ticks())
        return self

    async def __aexit__(self, *_: object) -> None:
        """End all connections."""
        if self._ticks is not None:
            self._ticks.cancel()
            with suppress(asyncio.CancelledError):
                await self._ticks
        self.viewers.drop_all()
        if self._runner is not None:
            await self._runner.cleanup()
        for workers in (self._workers, self._stop_workers):
            workers.close()

    async def _run_ticks(self) -> None:
        """One event for all viewers, again and again; nothing is done while nobody looks."""
        loop, period = asyncio.get_running_loop(), 1.0 / self._config.rate
        due = loop.time()
        while True:
            if len(self.viewers):
                self.viewers.publish(event(self._theatre.snapshot()))
            due = max(due + period, loop.time())
            await asyncio.sleep(due - loop.time())

    async def _handle(self, request: web.BaseRequest) -> Answer:
        objection = self._rules.objection(request.headers) if self._rules else "not ready"
        if objection:
            return answer(403, objection)
        path = request.path
        if path.startswith("/act/"):
            return await self._act(path.removeprefix("/act/"), request)
        if path not in (*self._files, "/picture", "/events"):
            return answer(404, "there is nothing here")
        if request.method not in ("GET", "HEAD"):
            return _refuse_method("GET")
        if path == "/events":
            return await self._events(request)
        return self._picture() if path == "/picture" else self._file(path)

    def _file(self, path: str) -> Answer:
        kind, data = self._files[path]
        return strict(web.Response(body=data, content_type=kind, charset="utf-8"))

    def _picture(self) -> Answer:
        picture = self._theatre.picture
        if picture is None:
            return answer(404, "there is no picture yet")
        headers = {STAMP: repr(picture.stamp)}
        return strict(web.Response(body=picture.data, content_type=picture.kind, headers=headers))

    async def _events(self, request: web.BaseRequest) -> Answer:
        viewer = self.viewers.join()
        if viewer is None:
            return answer(503, f"{self._config.max_viewers} pages are open, and no more may be")
        try:
            response = strict(web.StreamResponse())
            response.content_type, response.charset = "text/event-stream", "utf-8"
            await response.prepare(request)
            await self._follow(viewer, request, response)
            return response
        finally:
            self.viewers.leave(viewer)

    async def _follow(
        self, viewer: Viewer, request: web.BaseRequest, response: web.StreamResponse
    ) -> None:
        """Write events until the viewer goes or does not read."""
        if isinstance(request.protocol, Connection):
            request.protocol.stay()
        writing = asyncio.create_task(_write(viewer, response))
        dropped = asyncio.create_task(viewer.dropped())
        try:
            await asyncio.wait((writing, dropped), return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in (writing, dropped):
                task.cancel()
                with suppress(asyncio.CancelledError, ConnectionError):
                    await task
        if viewer.is_dropped and request.transport is not None:
            request.transport.abort()

    async def _act(self, name: str, request: web.BaseRequest) -> Answer:
        if name != STOP and name not in FORMS:
            return answer(404, f"there is no act {name[:40]!a}")
        if request.method != "POST":
            return _refuse_method("POST")
        if name == STOP:
            self._acts.send_stop()  # whatever else was sent with it
            return await self._carry_out(lambda acts: acts.stop(), self._stop_workers)
        if self._token.is_locked:
            return answer(429, "too many wrong tokens: wait two seconds")
        if not self._token.admits(_token_of(request.headers)):
            return answer(401, "the token is wrong: it is printed where the page was started")
        try:
            act = read_act(name, await _body(request))
        except BadRequestError as error:
            return answer(400, str(error))
        return await self._carry_out(act, self._workers)

    async def _carry_out(self, act: Callable[[Acts], Outcome], workers: Workers) -> Answer:
        if workers.are_busy:
            return answer(503, "too much is asked for at once")
        try:
            outcome = await workers.run(act, self._acts)
        except Exception as error:  # top of an act: the person must hear of it
            self._on_error(f"an act of the page failed: {error!r}")
            outcome = Outcome(False, "it failed; the log says why")
        text = json.dumps({"done": outcome.is_done, "words": outcome.words})
        return answer(200, text, "application/json")


async def _write(viewer: Viewer, response: web.StreamResponse) -> None:
    async for data in viewer:
        await response.write(data)


async def _body(request: web.BaseRequest) -> bytes:
    """All of it.

    Raises:
        BadRequestError: It is too long, or cut off.
    """
    data = b""
    try:
        while len(data) <= MOST_BODY and (more := await request.content.readany()):
            data += more
    except (web.PayloadAccessError, web.RequestPayloadError, OSError, ValueError):
        raise BadRequestError("the body is cut off or garbled") from None
    if len(data) > MOST_BODY:
        raise BadRequestError(f"the body is longer than {MOST_BODY} bytes")
    return data


def _token_of(headers: Mapping[str, str]) -> str:
    return headers.get("Authorization", "").removeprefix("Bearer ")


def _refuse_method(allowed: str) -> Answer:
    response = answer(405, f"only {allowed}")
    response.headers["Allow"] = allowed
    return response
