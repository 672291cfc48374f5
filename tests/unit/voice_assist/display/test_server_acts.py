# SPDX-License-Identifier: BSD-3-Clause
"""What a page asks the server to do over real sockets, without ROS."""

import asyncio
import json
import threading

import pytest

from support.waiting import PATIENCE
from tests.unit.voice_assist.display.support.served_page import RIGHT, assert_strict, run
from tests.unit.voice_assist.display.support.theatre import RecordedActs
from voice_assist.display.acts import FORMS, BadRequestError, read_act
from voice_assist.display.server import AT_WORK, MOST_BODY


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


async def first_done(posts, count):
    """Begin them all; those that are answered once there are so many, and the others."""
    done, waiting = set(), set(map(asyncio.ensure_future, posts))
    while len(done) < count:
        more, waiting = await asyncio.wait(waiting, return_when=asyncio.FIRST_COMPLETED)
        done |= more
    return done, waiting


def test_a_stop_is_sent_while_all_that_acts_is_busy():
    is_over = threading.Event()

    class Slow(RecordedActs):
        def stop(self):
            assert is_over.wait(PATIENCE)
            return super().stop()

    acts = Slow()

    async def act(_, session):
        posts = (session.post("/act/stop") for _ in range(AT_WORK + 3))
        refused, waiting = await first_done(posts, 3)
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
        _, waiting = await first_done(choose, 1)
        async with session.post("/act/stop") as answer:
            assert answer.status == 200 and (await answer.json())["done"]
        is_over.set()
        await asyncio.gather(*waiting)

    run(act, acts=Slow())


BODIES = {
    "microphone": {"name": "USB"},
    "answer": {"command": "tense", "yes": True},
    "grasp": {"x": 0.5, "y": 0.25, "stamp": 7.0},
}


@pytest.mark.parametrize("name", FORMS)
def test_every_act_but_a_stop_is_done_with_the_token_only(name):
    acts, body = RecordedActs(), BODIES[name]

    async def act(_, session):
        for headers in ({}, {"Authorization": "Bearer WRONG"}, {"Authorization": "Basic x"}):
            async with session.post(f"/act/{name}", json=body, headers=headers) as answer:
                assert answer.status == 401
                assert_strict(answer.headers)
        assert not acts.asked
        async with session.post(f"/act/{name}", json=body, headers=RIGHT) as answer:
            assert (answer.status, await answer.json()) == (200, {"done": True, "words": "done"})

    run(act, acts=acts)
    assert acts.asked == [(name, *body.values())]


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
        ({"x": 1.0}, r"x is 1\.0, allowed: a share of the picture, from 0 up to below 1"),
        ({"y": -0.1}, r"y is -0\.1, allowed: a share"),
        ({"y": True}, "y is True, allowed: a share"),
        ({"stamp": None}, "stamp is None, allowed: when the picture was taken, in seconds"),
        ({"stamp": -1.0}, r"stamp is -1\.0, allowed: when"),
        ({"stamp": float("inf")}, "stamp is inf, allowed: when"),
        ({"z": 0.0}, "grasp has x, y, stamp, z, allowed: x, y, stamp, and nothing else"),
    ],
)
def test_a_click_is_three_numbers(wrong, words):
    right = {"x": 0.5, "y": 0.0, "stamp": 7}
    acts = RecordedActs()
    read_act("grasp", json.dumps(right).encode())(acts)
    assert acts.asked == [("grasp", 0.5, 0.0, 7.0)]
    with pytest.raises(BadRequestError, match=words):
        read_act("grasp", json.dumps({**right, **wrong}).encode())


@pytest.mark.parametrize(
    ("name", "given", "words"),
    [
        ("microphone", b"{name", "the body is b'{name', allowed: JSON"),
        ("microphone", b"{}", "microphone has nothing, allowed: name, and nothing else"),
        ("microphone", b"[1]", "microphone has a list, allowed: name, and nothing else"),
        ("microphone", b'{"name": [1]}', "name is a list, allowed: printable text of 1 to 200"),
        ("answer", b'{"command": "tense", "yes": 1}', "yes is 1, allowed: true or false"),
    ],
)
def test_what_was_given_and_what_is_allowed_is_said_in_short(name, given, words):
    with pytest.raises(BadRequestError, match=words.replace("[", r"\[")) as error:
        read_act(name, given)
    assert len(str(error.value)) < 120


def test_what_was_given_is_shown_up_to_a_few_letters():
    for body in (b"?" * 10_000, json.dumps({"name": "\n" * 10_000}).encode()):
        with pytest.raises(BadRequestError, match="allowed") as error:
            read_act("microphone", body)
        assert len(str(error.value)) < 120


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
