# SPDX-License-Identifier: BSD-3-Clause
"""A question is for a loudspeaker to say, but not where to say the motion again does it."""

from types import SimpleNamespace

import pytest

from voice_assist.config import load_voice_config
from voice_assist.config.commands import LANGUAGES
from voice_assist.ros.robot.robot_acts import RobotActs
from voice_assist.types import Ask


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_question_is_said_aloud_unless_motions_are_said_twice(language):
    commands = load_voice_config(language=language).commands
    said = []
    acts = object.__new__(RobotActs)
    acts._commands, acts._publish = commands, SimpleNamespace(reply=said.append)
    for command in commands.commands:
        if command.is_motion:
            acts.do(Ask(command.phrase))
    assert bool(said) is not commands.said_twice
