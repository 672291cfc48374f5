# SPDX-License-Identifier: BSD-3-Clause
"""The devices node calls what is said to a voice node, and says what became of a call."""

import pytest
import rospy

from typed_config import ConfigError, load_yaml
from voice_assist.config import CONFIG_DIR
from voice_assist.config.devices import DeviceCallConfig
from voice_assist.ros.devices import targets
from voice_assist.ros.devices.node import spoken_commands
from voice_assist.ros.service_calls import Reply


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
    given = {"phrase": "light on", "kind": "service", "target": "/lamp", "within": 2.0}
    given |= {"type": "std_srvs/SetBool", "arguments": "{data: true}", "on_stop": ""}
    result = targets.make_target(DeviceCallConfig(**given)).call()
    words = "no answer within 2 s" + ("; it may still be carried out" if is_sent else "")
    assert (result.is_done, result.words) == (False, words)
