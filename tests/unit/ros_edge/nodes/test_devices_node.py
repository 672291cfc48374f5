# SPDX-License-Identifier: BSD-3-Clause
"""The devices node calls what is said to a voice node, and says what became of a call."""

from types import SimpleNamespace

import pytest
import rospy
from std_srvs.srv import SetBoolResponse

from typed_config import ConfigError, load_yaml
from typed_config.ros.service_calls import Reply
from voice_assist.config import CONFIG_DIR
from voice_assist.config.devices import DeviceCallConfig, devices_config
from voice_assist.devices.calls import CallResult, DeviceCalls
from voice_assist.ros.devices import targets
from voice_assist.ros.devices.node import DevicesNode, spoken_commands

LAMP = {"phrase": "light on", "kind": "service", "target": "/lamp", "within": 2.0}
LAMP |= {"type": "std_srvs/SetBool", "arguments": "{data: true}", "on_stop": ""}
OFF = LAMP | {"phrase": "off", "arguments": "{data: false}"}


def test_without_a_voice_node_it_is_named(monkeypatch):
    monkeypatch.setattr(rospy, "get_param", lambda name, default: default)
    words = r"voice_assist/commands is missing, allowed: the commands of a voice node"
    with pytest.raises(ConfigError, match=words):
        spoken_commands()


def test_what_can_be_said_is_what_the_voice_node_was_launched_with(monkeypatch):
    given = {"voice_assist/commands": load_yaml(CONFIG_DIR / "commands.yaml")}
    monkeypatch.setattr(rospy, "get_param", lambda name, default: given.get(name, default))
    assert "stop" in spoken_commands().phrases


@pytest.mark.parametrize("is_sent", [False, True])
def test_a_call_that_failed_is_not_made_later_or_says_that_it_may_be(monkeypatch, is_sent):
    reply = Reply(None, "no answer within 2 s", is_sent)
    monkeypatch.setattr(targets, "call_service", lambda *_, **__: reply)
    result = targets.make_target(DeviceCallConfig(**LAMP)).call()
    words = "no answer within 2 s" + ("; it may still be carried out" if is_sent else "")
    assert (result.is_done, result.words) == (False, words)
    assert result.may_have_effect is is_sent


@pytest.mark.parametrize("is_taken", [True, False])
def test_a_device_that_refuses_has_done_nothing(monkeypatch, is_taken):
    reply = Reply(SetBoolResponse(is_taken, "so"))
    monkeypatch.setattr(targets, "call_service", lambda *_, **__: reply)
    result = targets.make_target(DeviceCallConfig(**LAMP)).call()
    assert (result.is_done, result.words, result.may_have_effect) == (is_taken, "so", is_taken)


@pytest.mark.parametrize("is_refused", [True, False])
def test_the_node_does_not_undo_at_a_stop_what_a_device_refused(is_refused):
    node = object.__new__(DevicesNode)
    node._calls = DeviceCalls(devices_config({"calls": [LAMP | {"on_stop": "off"}, OFF]}))
    node._calls.said("light on")
    call, reported = node._calls.next(0.0), []
    result = CallResult(call, not is_refused, "", may_have_effect=not is_refused)
    node._targets = {"light on": SimpleNamespace(call=lambda _: result)}
    node._report = reported.append
    node._make(call, lambda: False)
    node._calls.stopped()
    undo = node._calls.next_undoing(0.0)
    assert reported == [result] and (undo is None) is is_refused
