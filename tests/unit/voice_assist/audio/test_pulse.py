# SPDX-License-Identifier: BSD-3-Clause
"""The sound of one source of a PulseAudio server; `parec` and the answers are made up here."""

import os
import threading
from types import SimpleNamespace

import pytest

from support.waiting import PATIENCE, wait_until
from voice_assist.audio.capture import pulse
from voice_assist.audio.capture.pulse import PulseStream
from voice_assist.audio.source import FRAME

PAREC = """#!/bin/sh
while :; do
    head -c 1024 /dev/zero
    sleep 0.01
done
"""


def row(name):
    return f"0\t{name}\tmodule\ts16le 1ch 16000Hz\tRUNNING"


@pytest.fixture
def server(tmp_path, monkeypatch):
    """Answers to what is asked of a server; its `parec` gives a block every 10 ms."""
    program = tmp_path / "parec"
    program.write_text(PAREC)
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setattr(pulse, "_CHECK_EVERY", 0.01)
    server = SimpleNamespace(sources=["headset"], asked=[])

    def ask(*words):
        server.asked.append(words)
        return [row(name) for name in server.sources]

    monkeypatch.setattr(pulse, "_ask", ask)
    return server


@pytest.fixture
def heard(server):
    """Blocks of the source `headset`, and its stream."""
    heard = SimpleNamespace(blocks=[])
    heard.stream = PulseStream("headset", lambda block, _: heard.blocks.append(block))
    yield heard
    heard.stream.close()


def hears_more(heard, count=5):
    wanted = len(heard.blocks) + count
    wait_until(lambda: len(heard.blocks) >= wanted, "blocks")


def asks_more(server, count=3):
    wanted = len(server.asked) + count
    wait_until(lambda: len(server.asked) >= wanted, "checks")


def has_ended(heard):
    return heard.stream._recorder.poll() is not None


def test_a_source_that_is_listed_is_heard_and_only_the_list_is_asked_for(server, heard):
    asks_more(server)
    hears_more(heard)
    assert set(server.asked) == {("list", "short", "sources")}
    assert heard.blocks[0].shape == (FRAME, 1)


def test_a_server_that_does_not_answer_says_nothing_of_the_source(server, heard):
    server.sources = []
    asks_more(server)
    hears_more(heard)
    assert not has_ended(heard)


def test_a_list_without_the_source_ends_the_sound(server, heard):
    hears_more(heard)
    server.sources = ["other"]
    wait_until(lambda: has_ended(heard), "the end of the sound")


def test_neither_the_sound_nor_its_end_waits_for_an_answer(server, heard, monkeypatch):
    may_answer, has_asked, answers = threading.Event(), threading.Event(), []

    def hang(*_):
        has_asked.set()
        may_answer.wait(PATIENCE)
        answers.append(row("other"))
        return answers

    monkeypatch.setattr(pulse, "_ask", hang)
    assert has_asked.wait(PATIENCE)
    hears_more(heard)
    heard.stream.close()
    assert has_ended(heard) and not answers
    may_answer.set()
    wait_until(lambda: answers, "the late answer")
