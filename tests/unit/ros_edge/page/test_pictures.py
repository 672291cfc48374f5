# SPDX-License-Identifier: BSD-3-Clause
"""Why the page has no picture is logged once, and in words that are true."""

import time
from types import SimpleNamespace

import pytest
import rospy

from typed_config import load_file
from typed_config.ros.service_calls import Reply
from voice_assist.config.display import FILE, DisplayConfig
from voice_assist.display.theatre import Theatre
from voice_assist.ros.display import pictures as pictures_module
from voice_assist.ros.display.pictures import LARGEST, Pictures

PNG = b"\x89PNG\r\n\x1a\n"
STAMP = SimpleNamespace(to_sec=lambda: 1.0)


@pytest.fixture
def pictures(monkeypatch):
    monkeypatch.setattr(pictures_module.threading.Thread, "start", lambda _: None)
    theatre = Theatre(0.5, time.monotonic, time.time)
    known = SimpleNamespace(hear=lambda *_, **__: None)
    return Pictures(load_file(DisplayConfig, FILE).picture, theatre, lambda: True, known)


def come(pictures, data):
    """A picture comes."""
    pictures._on_picture(SimpleNamespace(data=data, header=SimpleNamespace(stamp=STAMP)))


def ask(monkeypatch, pictures):
    """Ask for one picture, which is promised."""
    ended = iter([False, True])
    reply = Reply(SimpleNamespace(success=True, message=""))
    monkeypatch.setattr(rospy, "is_shutdown", lambda: next(ended))
    monkeypatch.setattr(pictures_module, "call_service", lambda *_, **__: reply)
    monkeypatch.setattr(rospy.rostime, "wallsleep", lambda _: None)
    pictures._ask()


def test_too_large_a_picture_is_reported_once_with_its_size_and_what_is_allowed(
    monkeypatch, logged, pictures
):
    for more in (1, 2, 3):  # each has another size
        ask(monkeypatch, pictures)
        come(pictures, PNG + bytes(LARGEST + more - len(PNG)))
    assert logged == [
        "no picture of the scene: a picture is larger than the 8000000 bytes that are allowed"
        " (8000001 bytes)"
    ]
    assert pictures._theatre.picture is None


def test_a_trouble_that_comes_back_is_reported_again(logged, pictures):
    for data in (b"GIF89a", PNG, b"GIF89a"):
        come(pictures, data)
    assert logged == ["no picture of the scene: a picture is neither PNG nor JPEG (6 bytes)"] * 2
    assert pictures._theatre.picture.data == PNG
