# SPDX-License-Identifier: BSD-3-Clause
"""The devices node calls what is said to a voice node, and says so where none was launched."""

import pytest
import rospy

from typed_config import ConfigError, load_yaml
from voice_assist.config import CONFIG_DIR
from voice_assist.ros.devices.node import spoken_commands


def test_without_a_voice_node_it_is_named(monkeypatch):
    monkeypatch.setattr(rospy, "get_param", lambda name, default: default)
    words = r"voice_assist/commands is missing, allowed: the commands of a voice node"
    with pytest.raises(ConfigError, match=words):
        spoken_commands()


def test_what_can_be_said_is_what_the_voice_node_was_launched_with(monkeypatch):
    given = {"voice_assist/commands": load_yaml(CONFIG_DIR / "commands.yaml")}
    monkeypatch.setattr(rospy, "get_param", lambda name, default: given.get(name, default))
    assert "stop" in spoken_commands().phrases
