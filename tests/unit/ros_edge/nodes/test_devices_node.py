# SPDX-License-Identifier: BSD-3-Clause
"""The devices node calls what is said to a voice node, and says what became of a call."""

import threading
from types import SimpleNamespace

import pytest
import rospy
from std_srvs.srv import SetBoolResponse

from typed_config import ConfigError, load_yaml
from voice_assist.config import CONFIG_DIR
from voice_assist.config.devices import DeviceCallConfig
from voice_assist.ros.devices.node import spoken_commands
from voice_assist.ros.devices.targets import make_target


def test_without_a_voice_node_it_is_named(monkeypatch):
    monkeypatch.setattr(rospy, "get_param", lambda name, default: default)
    words = r"voice_assist/commands is missing, allowed: the commands of a voice node"
    with pytest.raises(ConfigError, match=words):
        spoken_commands()


def test_what_can_be_said_is_what_the_voice_node_was_launched_with(monkeypatch):
    given = {"voice_assist/commands": load_yaml(CONFIG_DIR / "commands.yaml")}
    monkeypatch.setattr(rospy, "get_param", lambda name, default: given.get(name, default))
    assert "stop" in spoken_commands().phrases


def lamp(within):
    given = {"phrase": "light on", "kind": "service", "target": "/lamp", "within": within}
    given |= {"type": "std_srvs/SetBool", "arguments": "{data: true}", "on_stop": ""}
    return make_target(DeviceCallConfig(**given))


class HungLamp:
    """A service that hangs before it is sent the request, or after it."""

    def __init__(self, is_sent):
        self.is_sent, self.thaws, self.ended = is_sent, threading.Event(), threading.Event()
        self.received, self.transport = [], None

    def __call__(self, request):
        try:
            if not self.is_sent:
                self.thaws.wait(60.0)
            request.serialize(SimpleNamespace(write=self.received.append))
            self.thaws.wait(60.0)
            return SetBoolResponse(True, "on")
        finally:
            self.ended.set()

    def close(self):
        self.transport = None


@pytest.mark.parametrize(("is_sent", "within"), [(False, 0.05), (True, 2.0)])
def test_a_call_that_failed_is_not_made_later_or_says_that_it_may_be(monkeypatch, is_sent, within):
    service = HungLamp(is_sent)
    monkeypatch.setattr(rospy, "ServiceProxy", lambda *_, **__: service)
    result = lamp(within).call()
    words = f"no answer within {within:g} s" + ("; it may still be carried out" if is_sent else "")
    assert (result.is_done, result.words) == (False, words)
    service.thaws.set()
    assert service.ended.wait(10.0)
    assert service.received == ([b"\x01"] if is_sent else [])
