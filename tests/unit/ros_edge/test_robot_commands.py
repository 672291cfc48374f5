# SPDX-License-Identifier: BSD-3-Clause
"""A spoken phrase may call what the controller takes from a voice, and nothing else."""

from dataclasses import replace

import pytest

from rst_control.commands.spec import Role
from rst_control.commands.table import COMMANDS
from voice_assist.config import load_voice_config
from voice_assist.config.commands import NOT_MOTIONS
from voice_assist.errors import CommandsError
from voice_assist.ros.robot.robot_commands import require_known

SHIPPED = load_voice_config().commands


@pytest.mark.parametrize("command", ["dance", "insert"])  # unknown, and taken by hand only
def test_a_call_that_the_controller_refuses_from_a_voice_ends_the_start(command):
    first, tense, *rest = SHIPPED.commands
    changed = replace(SHIPPED, commands=(first, replace(tense, command=command), *rest))
    with pytest.raises(CommandsError, match=rf"commands\[1\]\.command is '{command}', .*tense.*"):
        require_known(changed)


def test_the_shipped_phrases_call_what_the_controller_knows():
    require_known(SHIPPED)


def test_the_calls_that_begin_no_motion_are_those_of_the_controller():
    without = {spec.phrase for spec in COMMANDS.values() if spec.role is not Role.MOTION}
    assert set(NOT_MOTIONS) == without


def test_an_amount_has_a_unit_that_the_command_takes():
    with_amounts = load_voice_config(commands__amounts=True).commands
    require_known(with_amounts)
    *rest, last = with_amounts.commands
    changed = replace(with_amounts, commands=(*rest, replace(last, called="release")))
    with pytest.raises(CommandsError, match="allowed: no amount with 'release'"):
        require_known(changed)
