# SPDX-License-Identifier: BSD-3-Clause
"""The page's picture and clicks: by whom, and without waiting for ever."""

import socket
import time
from types import SimpleNamespace

import pytest
import rospy
from sensor_msgs.msg import CompressedImage

from rst_control.config import CONFIG_FOLDER, SceneConfig
from rst_control.tissue.sheet import rest_points
from tests.unit.voice_assist.support.heard import Heard
from typed_config import load_file, load_yaml
from typed_config.ros import xmlrpc
from typed_config.ros.service_calls import Reply
from voice_assist.config.believed import believed_config
from voice_assist.config.display import FILE, DisplayConfig
from voice_assist.display.picking import NotOnTissueError
from voice_assist.ros.display import endoscope
from voice_assist.ros.display import pictures as pictures_module
from voice_assist.ros.display.pictures import Pictures

CONFIG = load_file(DisplayConfig, FILE).picture


@pytest.fixture
def heard():
    return Heard()


@pytest.fixture
def pictures(monkeypatch, heard):
    monkeypatch.setattr(pictures_module.threading.Thread, "start", lambda _: None)
    theatre = SimpleNamespace(see_picture_period=lambda _: None, see_picture=lambda *_: None)
    return Pictures(CONFIG, theatre, lambda: True, heard)


@pytest.fixture
def period(monkeypatch, pictures):
    """Time between two pictures [s] that the page is told after pictures that far apart [s]."""
    times, told = [100.0], []
    clock = SimpleNamespace(monotonic=lambda: times[-1])
    monkeypatch.setattr(pictures_module, "time", clock)
    pictures._theatre.see_picture_period = told.append
    picture = CompressedImage(data=b"\x89PNG\r\n\x1a\n")

    def after(*intervals):
        for interval in intervals:
            times.append(times[-1] + interval)
            pictures._on_picture(picture)
        return told[-1]

    after(0.0)
    return after


def test_pictures_are_taken_from_the_endoscope_alone_which_is_the_simulator_as_shipped(
    pictures, heard
):
    assert heard.by == {CONFIG.topic: "camera"}
    assert believed_config(None).camera == ("/robot",)


def test_a_camera_that_becomes_ten_times_slower_or_more_is_learnt(period):
    assert period(*[1.0] * 30) == pytest.approx(1.0)
    assert period(*[10.5] * 40) == pytest.approx(10.5, rel=0.01)
    assert period(*[200.0] * 60) == pytest.approx(200.0, rel=0.01)


@pytest.mark.parametrize("first", [[], [1.0] * 30])
def test_one_pause_does_not_let_old_pictures_count_as_new(period, first):
    """As where nobody looked for a while."""
    period(*first)
    for _ in range(5):
        assert period(3000.0) == period(1.0) == pytest.approx(CONFIG.period)


def test_two_pauses_in_a_row_count_for_little(period):
    assert period(*[1.0] * 30, 3000.0, 3000.0) < 3.0 * CONFIG.period


def test_a_fast_cameras_picture_is_old_no_sooner_than_the_document_says(period):
    """2.5 s, by page.js: twice the period and `old_after`."""
    fastest = min(period(interval) for interval in [1 / 30] * 200)
    assert 2.0 * fastest + load_file(DisplayConfig, FILE).old_after >= 2.5


@pytest.mark.parametrize(
    ("reply", "logged"),
    [
        (Reply(SimpleNamespace(success=True, message="")), []),
        (Reply(SimpleNamespace(success=False, message="no screen")), ["no screen"]),
        (Reply(None, "unavailable"), []),  # nobody offers pictures
        (Reply(None, "no answer within 10 s", True), ["no answer within 10 s"]),
    ],
)
def test_a_service_that_hangs_is_given_up_and_named(monkeypatch, pictures, reply, logged):
    said, asked, ended = [], [], iter([False, True])
    monkeypatch.setattr(rospy, "logwarn", lambda words, *parts: said.append(words % parts))
    monkeypatch.setattr(rospy, "is_shutdown", lambda: next(ended))
    monkeypatch.setattr(rospy.rostime, "wallsleep", lambda _: None)
    monkeypatch.setattr(
        pictures_module, "call_service", lambda *_, within: asked.append(within) or reply
    )
    pictures._ask()
    assert asked == [pictures_module.WITHIN]
    assert said == [f"no picture of the scene: {words}" for words in logged]


def test_a_click_does_not_wait_for_ever_for_a_master_that_hangs(monkeypatch):
    monkeypatch.setattr(xmlrpc, "ANSWER_TIME", 0.05)
    with socket.create_server(("127.0.0.1", 0)) as master:  # takes connections, answers none
        port = master.getsockname()[1]
        monkeypatch.setenv("ROS_MASTER_URI", f"http://127.0.0.1:{port}")
        began = time.monotonic()
        with pytest.raises(NotOnTissueError, match="the ROS master does not say within"):
            endoscope._sheet()
        assert time.monotonic() - began < 10.0


def test_a_click_means_the_tissue_of_the_controller_that_was_launched(monkeypatch):
    given = {}
    monkeypatch.setattr(endoscope, "parameter", given.get)
    with pytest.raises(NotOnTissueError, match="no controller was launched"):
        endoscope._sheet()
    given["/controller/scene"] = load_yaml(CONFIG_FOLDER / "scene.yaml")
    tissue = load_file(SceneConfig, CONFIG_FOLDER / "scene.yaml").tissue
    assert (endoscope._sheet().nodes == rest_points(tissue)).all()
