# SPDX-License-Identifier: BSD-3-Clause
"""What the bridge asks of OpenRST's node: one thing at a time, also where it never answers."""

import threading
from dataclasses import replace
from types import SimpleNamespace

import pytest

from rst_control.kinova.config import load_kinova_config
from rst_control.kinova.homing import HomingFailed
from rst_control.ros.kinova import hardware
from rst_control.ros.kinova.hardware import KinovaHardware

LOST = [  # how a call ends whose node is ended
    hardware.rospy.ServiceException("gone"),
    hardware.rospy.exceptions.TransportTerminated("gone"),
    ConnectionResetError("gone"),
]


def hardware_to(monkeypatch, call, limit):
    """Hardware whose requests to OpenRST are calls of this, waited for up to a limit [s]."""
    config = load_kinova_config().bridge
    monkeypatch.setattr(hardware.rospy, "Publisher", lambda *_, **__: None)
    monkeypatch.setattr(hardware.rospy, "wait_for_service", lambda *_: None)
    monkeypatch.setattr(hardware.rospy, "ServiceProxy", lambda *_: call)
    return KinovaHardware(replace(config, tool=replace(config.tool, homing_limit=limit)), (), None)


@pytest.mark.parametrize("error", LOST)
def test_nothing_is_asked_of_openrst_until_its_last_request_has_ended(monkeypatch, error):
    """It would serve both at once: two homings would drive the same motors."""
    asked, is_ended = [], threading.Event()

    def call(message):
        asked.append(message)
        if message == "calibrate":
            assert is_ended.wait(30.0)
            raise error
        return SimpleNamespace(succeeded=True)

    tool = hardware_to(monkeypatch, call, limit=0.05)
    with pytest.raises(HomingFailed, match=r'"calibrate" was not answered within'):
        tool.request("calibrate")
    for message in ("connect", "calibrate"):
        words = r'"calibrate" is still not answered: end OpenRST\'s node'
        with pytest.raises(HomingFailed, match=words):
            tool.request(message)
    assert asked == ["calibrate"]
    is_ended.set()
    (waiting,) = [t for t in threading.enumerate() if t.name == "openrst_request"]
    waiting.join(30.0)
    assert tool.request("connect") is True
    assert asked == ["calibrate", "connect"]


@pytest.mark.parametrize("error", LOST)
def test_a_request_whose_node_is_lost_says_so_at_once(monkeypatch, error):
    def call(_):
        raise error

    tool = hardware_to(monkeypatch, call, limit=30.0)
    with pytest.raises(HomingFailed, match='"connect" was not answered: gone'):
        tool.request("connect")
